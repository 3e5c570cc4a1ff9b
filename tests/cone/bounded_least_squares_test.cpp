#include "stiction/cone/bounded_least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "stiction/core/random.hpp"

namespace stiction::cone {
namespace {

Eigen::MatrixXd random_matrix(core::Random& random, Eigen::Index m, Eigen::Index n) {
  return Eigen::MatrixXd::NullaryExpr(m, n, [&] { return random.normal(); });
}

TEST(BoundedLeastSquares, WideBounds_IsTheRegularisedSolution) {
  core::Random random(1, 0);
  const Eigen::MatrixXd A = random_matrix(random, 3, 8);
  const Eigen::VectorXd b = random_matrix(random, 3, 1);
  const Eigen::VectorXd wide = Eigen::VectorXd::Constant(8, std::numeric_limits<double>::infinity());
  Eigen::VectorXd x;
  ASSERT_TRUE(solve_bounded_least_squares(A, b, 1e-3, -wide, wide, x));
  const Eigen::MatrixXd normal = A.transpose() * A + 1e-3 * Eigen::MatrixXd::Identity(8, 8);
  EXPECT_LT((x - normal.ldlt().solve(A.transpose() * b)).norm(), 1e-9);
}

/// Optimality from the definition: the gradient vanishes inside and points outwards at a bound.
TEST(BoundedLeastSquares, RandomProblems_SatisfyKktConditions) {
  core::Random random(2, 0);
  int at_bound = 0;
  for (int problem = 0; problem < 2000; ++problem) {
    const Eigen::Index m = 1 + random.index(6), n = m + random.index(14);
    const Eigen::MatrixXd A = random_matrix(random, m, n);
    const Eigen::VectorXd b = 3 * random_matrix(random, m, 1);
    const double gamma = std::pow(10.0, random.uniform(-6, 0));
    Eigen::VectorXd lower(n), upper(n), x;
    for (Eigen::Index j = 0; j < n; ++j) {
      lower[j] = -random.uniform();
      upper[j] = lower[j] + (random.chance(0.1) ? 0.0 : random.uniform());  // some are fixed, some exclude 0
    }
    ASSERT_TRUE(solve_bounded_least_squares(A, b, gamma, lower, upper, x));
    const Eigen::VectorXd gradient = A.transpose() * (A * x - b) + gamma * x;
    const double tolerance = 1e-7 * (1 + A.norm() * b.norm()) / std::sqrt(gamma);
    for (Eigen::Index j = 0; j < n; ++j) {
      ASSERT_GE(x[j], lower[j]);
      ASSERT_LE(x[j], upper[j]);
      if (lower[j] == upper[j]) continue;
      if (x[j] == lower[j]) {
        EXPECT_GE(gradient[j], -tolerance);
        ++at_bound;
      } else if (x[j] == upper[j]) {
        EXPECT_LE(gradient[j], tolerance);
        ++at_bound;
      } else {
        EXPECT_NEAR(gradient[j], 0, tolerance);
      }
    }
  }
  EXPECT_GT(at_bound, 2000);
}

}  // namespace
}  // namespace stiction::cone
