#include "stiction/cone/cone_least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "stiction/cone/bounded_least_squares.hpp"
#include "stiction/core/random.hpp"

namespace stiction::cone {
namespace {

const Eigen::Matrix3d kOne = Eigen::Matrix3d::Identity();
const Eigen::Vector3d kFar = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());

TEST(ConeLeastSquares, OneCone_IsTheProjectionOntoIt) {
  ConeLeastSquares problem(3);
  problem.add_cone(kOne, Eigen::Vector3d::Zero());
  Eigen::VectorXd x;
  ASSERT_TRUE(problem.solve(kOne, Eigen::Vector3d(0, 2, 0), 1e-9, -kFar, kFar, x));
  EXPECT_LT((x - Eigen::Vector3d(1, 1, 0)).norm(), 1e-5);  // of a point at a right angle to the axis
  problem.clear_cones();
  ASSERT_TRUE(problem.solve(kOne, Eigen::Vector3d(0, 2, 0), 1e-9, -kFar, kFar, x));
  EXPECT_LT((x - Eigen::Vector3d(0, 2, 0)).norm(), 1e-5);
}

TEST(ConeLeastSquares, NoCones_IsBoundedLeastSquares) {
  core::Random random(3, 0);
  const auto draw = [&] { return random.normal(); };
  for (const int n : {3, 7, 19}) {
    ConeLeastSquares problem(n);
    for (int k = 0; k < 20; ++k) {
      const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(3, n, draw);
      const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(3, draw);
      const Eigen::VectorXd bound = Eigen::VectorXd::Constant(n, 0.2);
      Eigen::VectorXd x, expected;
      ASSERT_TRUE(problem.solve(A, b, 1e-2, -bound, bound, x));
      ASSERT_TRUE(solve_bounded_least_squares(A, b, 1e-2, -bound, bound, expected));
      const auto cost = [&](const Eigen::VectorXd& y) { return (A * y - b).squaredNorm() + 1e-2 * y.squaredNorm(); };
      // 2 n rows, each with a complementarity of 1e-7 of the largest number of Aᵀb
      EXPECT_LT(std::abs(cost(x) - cost(expected)), 4 * n * 1e-7 * (A.transpose() * b).cwiseAbs().maxCoeff()) << n;
    }
  }
}

/// No feasible point that was drawn is better.
TEST(ConeLeastSquares, RandomCones_AreKeptAndNothingBetterIsNear) {
  core::Random random(4, 0);
  const auto draw = [&] { return random.normal(); };
  const int n = 6;
  int tight = 0;
  for (int k = 0; k < 50; ++k) {
    ConeLeastSquares problem(n);
    const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(4, n, draw);
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(4, draw), bound = Eigen::VectorXd::Constant(n, 1.0);
    const Eigen::MatrixXd G = Eigen::MatrixXd::NullaryExpr(3, n, draw);
    const Eigen::Vector3d g(0.3, 0.1, -0.1);  // 0 is inside
    problem.add_cone(G, g);
    const auto room = [&](const Eigen::VectorXd& x) {
      const Eigen::Vector3d w = G * x + g;
      return w[0] - w.tail<2>().norm();
    };
    const auto cost = [&](const Eigen::VectorXd& x) { return (A * x - b).squaredNorm() + 1e-2 * x.squaredNorm(); };
    Eigen::VectorXd x;
    ASSERT_TRUE(problem.solve(A, b, 1e-2, -bound, bound, x));
    EXPECT_GT(room(x), -1e-6);
    tight += room(x) < 1e-3;
    for (int trial = 0; trial < 200; ++trial) {
      const Eigen::VectorXd y = (x + 0.05 * Eigen::VectorXd::NullaryExpr(n, draw)).cwiseMax(-bound).cwiseMin(bound);
      if (room(y) >= 0) {
        EXPECT_GE(cost(y), cost(x) - 1e-5);
      }
    }
  }
  EXPECT_GT(tight, 10) << "cones that do not matter say nothing";
}

/// A push that is to go nowhere: its answer is 0, whatever the numbers of A are.
TEST(ConeLeastSquares, NothingToReach_IsNoMotion) {
  for (const double size : {1e-3, 1.0, 10.0, 1e6}) {
    ConeLeastSquares problem(3);
    problem.add_cone(Eigen::Matrix3d::Identity(), Eigen::Vector3d(1, 0, 0));
    const Eigen::MatrixXd A = size * Eigen::MatrixXd::Identity(3, 3);
    const Eigen::VectorXd bound = Eigen::VectorXd::Constant(3, 2);
    for (const double b : {0.0, 1e-310}) {
      Eigen::VectorXd x;
      ASSERT_TRUE(problem.solve(A, Eigen::VectorXd::Constant(3, b), 1e-4, -bound, bound, x)) << size;
      EXPECT_LT(x.norm(), 1e-6) << size;
    }
  }
}

TEST(ConeLeastSquares, NoPointInTheCone_IsFalse) {
  ConeLeastSquares problem(3);
  problem.add_cone(Eigen::Matrix3d::Zero(), Eigen::Vector3d(-1, 0, 0));
  Eigen::VectorXd x;
  EXPECT_FALSE(problem.solve(kOne, Eigen::Vector3d(1, 1, 1), 1e-3, -kFar, kFar, x));
}

}  // namespace
}  // namespace stiction::cone
