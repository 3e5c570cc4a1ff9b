#include "stiction/cone/cone_least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace stiction::cone {
namespace {

std::vector<int> all_variables(int n) {
  std::vector<int> variables(static_cast<std::size_t>(n));
  std::iota(variables.begin(), variables.end(), 0);
  return variables;
}

/// One group, since A couples all unknowns, and one support, since every row may touch all of them.
std::shared_ptr<const cone::Layout> dense_layout(int n) {
  const auto variables = all_variables(n);
  auto layout = std::make_shared<cone::Layout>(n, std::vector<std::vector<int>>{variables});
  layout->add_support(variables);
  return layout;
}

}  // namespace

ConeLeastSquares::ConeLeastSquares(int n) : n_(n), support_(0), problem_(dense_layout(n), 32, 0), work_(problem_.layout_ptr()) {}

void ConeLeastSquares::add_cone(const Eigen::Ref<const Eigen::MatrixXd>& G, const Eigen::Vector3d& g) { cones_.push_back({G, g}); }

bool ConeLeastSquares::solve(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::VectorXd>& b, double gamma,
                             const Eigen::Ref<const Eigen::VectorXd>& lower, const Eigen::Ref<const Eigen::VectorXd>& upper,
                             Eigen::VectorXd& x) {
  // The solver's tolerances assume numbers of about 1, so the problem is scaled until the largest number of Aᵀb is 1.
  const Eigen::VectorXd gradient = A.transpose() * b;
  const double steepest = gradient.cwiseAbs().maxCoeff();
  const Eigen::MatrixXd Q = A.transpose() * A;
  // Without a gradient (for example a push that should not move anything) this scale would make Q infinite. Then the largest number of Q is
  // scaled to 1.
  constexpr double kNone = 1e-150;
  const double largest = Q.diagonal().maxCoeff() + gamma;
  const double scale = 1 / (steepest > kNone * largest ? steepest : std::max(largest, std::numeric_limits<double>::min()));
  problem_.clear();
  for (int j = 0; j < n_; ++j) {
    for (int i = 0; i <= j; ++i) problem_.set_Q(i, j, scale * (Q(i, j) + (i == j ? gamma : 0.0)));
    problem_.set_b(j, -scale * gradient[j]);
    const auto id = static_cast<std::uint64_t>(2 * j);
    if (std::isfinite(lower[j])) problem_.add_bound(id, j, 1, -lower[j], 0);
    if (std::isfinite(upper[j])) problem_.add_bound(id + 1, j, -1, upper[j], 0);
  }
  for (std::size_t i = 0; i < cones_.size(); ++i)
    problem_.add_cone(static_cast<std::uint64_t>(i), support_, cones_[i].G.data(), cones_[i].g.data(), 0);
  cone::Options options;
  options.tol_complementarity = 1e-7;
  options.tol_kkt = 1e-6;
  options.warm_start = false;
  options.sensitivities = false;
  if (cone::solve(problem_, options, work_, result_) != core::Status::Solved) return false;
  x = result_.x;
  return true;
}

}  // namespace stiction::cone
