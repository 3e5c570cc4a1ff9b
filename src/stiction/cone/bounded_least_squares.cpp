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

}  // namespace

bool solve_bounded_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::VectorXd>& b, double gamma,
                                 const Eigen::Ref<const Eigen::VectorXd>& lower, const Eigen::Ref<const Eigen::VectorXd>& upper,
                                 Eigen::VectorXd& x) {
  const Eigen::Index m = A.rows();
  const Eigen::Index n = A.cols();
  std::vector<Side> side(static_cast<std::size_t>(n), Side::Free);
  x = Eigen::VectorXd::Zero(n).cwiseMax(lower).cwiseMin(upper);  // feasible throughout
  Eigen::MatrixXd S(m, m);
  Eigen::VectorXd r(m), y(m), target(n);

  for (Eigen::Index iteration = 0; iteration < 4 * n + 20; ++iteration) {
    S.setIdentity();
    S *= gamma;
    r = b;
    for (Eigen::Index j = 0; j < n; ++j) {
      if (side[static_cast<std::size_t>(j)] == Side::Free) {
        S.noalias() += A.col(j) * A.col(j).transpose();
      } else {
        r.noalias() -= A.col(j) * x[j];
      }
    }
    y = S.ldlt().solve(r);  // residual of the free problem, divided by γ: (b − A x)/γ

    // Walk from x to the minimiser over the free variables; the first bound on the way becomes active.
    double t = 1.0;
    Eigen::Index blocking = -1;
    for (Eigen::Index j = 0; j < n; ++j) {
      if (side[static_cast<std::size_t>(j)] != Side::Free) continue;
      target[j] = A.col(j).dot(y);
      const double move = target[j] - x[j];
      const double room = move > 0 ? upper[j] - x[j] : lower[j] - x[j];
      if (std::abs(move) > std::abs(room) && std::abs(room) < t * std::abs(move)) {
        t = std::abs(room) / std::abs(move);
        blocking = j;
      }
    }
    for (Eigen::Index j = 0; j < n; ++j) {
      if (side[static_cast<std::size_t>(j)] == Side::Free) x[j] += t * (target[j] - x[j]);
    }
    if (blocking >= 0) {
      const bool up = target[blocking] > x[blocking];
      side[static_cast<std::size_t>(blocking)] = up ? Side::Upper : Side::Lower;
      x[blocking] = up ? upper[blocking] : lower[blocking];
      continue;
    }

    // At the minimiser of the face: release the bound whose multiplier is most wrong. With y = (b − Ax)/γ the gradient of the
    // objective along x_j is 2γ(x_j − a_jᵀy).
    double worst = 1e-12 * (1.0 + x.cwiseAbs().maxCoeff());
    Eigen::Index release = -1;
    for (Eigen::Index j = 0; j < n; ++j) {
      const Side s = side[static_cast<std::size_t>(j)];
      if (s == Side::Free || lower[j] == upper[j]) continue;
      const double inward = (s == Side::Lower ? 1.0 : -1.0) * (A.col(j).dot(y) - x[j]);
      if (inward > worst) {
        worst = inward;
        release = j;
      }
    }
    if (release < 0) return true;
    side[static_cast<std::size_t>(release)] = Side::Free;
  }
  return false;
}

}  // namespace stiction::cone
