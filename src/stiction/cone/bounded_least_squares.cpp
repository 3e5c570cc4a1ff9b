#include "stiction/cone/bounded_least_squares.hpp"

#include <Eigen/Cholesky>
#include <vector>

namespace stiction::cone {
namespace {

enum class Side : char {
  Free,
  Lower,
  Upper
};

using Matrix = Eigen::Ref<const Eigen::MatrixXd>;
using Vector = Eigen::Ref<const Eigen::VectorXd>;

std::size_t at(Eigen::Index j) { return static_cast<std::size_t>(j); }

/// y = (b − A x)/γ at the minimiser over the free variables.
void solve_face(const Matrix& A, const Vector& b, double gamma, const std::vector<Side>& side, const Eigen::VectorXd& x, Eigen::MatrixXd& S,
                Eigen::VectorXd& r, Eigen::VectorXd& y) {
  S.setIdentity();
  S *= gamma;
  r = b;
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    if (side[at(j)] == Side::Free) {
      S.noalias() += A.col(j) * A.col(j).transpose();
    } else {
      r.noalias() -= A.col(j) * x[j];
    }
  }
  y = S.ldlt().solve(r);
}

/// Moves x towards the minimiser over the free variables. The first bound on the way becomes active. @returns false if no bound is met
bool walk_to_bound(const Matrix& A, const Eigen::VectorXd& y, const Vector& lower, const Vector& upper, std::vector<Side>& side,
                   Eigen::VectorXd& target, Eigen::VectorXd& x) {
  double t = 1.0;
  Eigen::Index blocking = -1;
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    if (side[at(j)] != Side::Free) continue;
    target[j] = A.col(j).dot(y);
    const double move = target[j] - x[j];
    const double room = move > 0 ? upper[j] - x[j] : lower[j] - x[j];
    if (std::abs(move) > std::abs(room) && std::abs(room) < t * std::abs(move)) {
      t = std::abs(room) / std::abs(move);
      blocking = j;
    }
  }
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    if (side[at(j)] == Side::Free) x[j] += t * (target[j] - x[j]);
  }
  if (blocking < 0) return false;
  const bool up = target[blocking] > x[blocking];
  side[at(blocking)] = up ? Side::Upper : Side::Lower;
  x[blocking] = up ? upper[blocking] : lower[blocking];
  return true;
}

/// Index of the active bound whose multiplier violates its sign most, −1 if none does. With y = (b − Ax)/γ the gradient of the objective
/// along x_j is 2γ(x_j − a_jᵀy).
Eigen::Index worst_bound(const Matrix& A, const Eigen::VectorXd& y, const Vector& lower, const Vector& upper, const std::vector<Side>& side,
                         const Eigen::VectorXd& x) {
  double worst = 1e-12 * (1.0 + x.cwiseAbs().maxCoeff());
  Eigen::Index release = -1;
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    const Side s = side[at(j)];
    if (s == Side::Free || lower[j] == upper[j]) continue;
    const double inward = (s == Side::Lower ? 1.0 : -1.0) * (A.col(j).dot(y) - x[j]);
    if (inward > worst) {
      worst = inward;
      release = j;
    }
  }
  return release;
}

}  // namespace

bool solve_bounded_least_squares(const Matrix& A, const Vector& b, double gamma, const Vector& lower, const Vector& upper,
                                 Eigen::VectorXd& x) {
  const Eigen::Index m = A.rows();
  const Eigen::Index n = A.cols();
  std::vector<Side> side(at(n), Side::Free);
  x = Eigen::VectorXd::Zero(n).cwiseMax(lower).cwiseMin(upper);  // x stays feasible throughout
  Eigen::MatrixXd S(m, m);
  Eigen::VectorXd r(m), y(m), target(n);
  for (Eigen::Index iteration = 0; iteration < 4 * n + 20; ++iteration) {
    solve_face(A, b, gamma, side, x, S, r, y);
    if (walk_to_bound(A, y, lower, upper, side, target, x)) continue;
    const Eigen::Index release = worst_bound(A, y, lower, upper, side, x);
    if (release < 0) return true;
    side[at(release)] = Side::Free;
  }
  return false;
}

}  // namespace stiction::cone
