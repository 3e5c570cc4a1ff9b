#include <gtest/gtest.h>

#include <Eigen/LU>

#include "stiction/control/quasi_static.hpp"
#include "stiction/core/random.hpp"
#include "support/message_of.hpp"

namespace stiction::control::test {
namespace {

using core::Status;
using Eigen::Index;
using Eigen::VectorXd;

struct Arm {
  VectorXd K, q, u;
  RowMatrix J;
};

Arm random_arm(core::Random& random, Index n, Index m) {
  Arm arm{VectorXd(n), VectorXd(n), VectorXd(n), RowMatrix(m, n)};
  for (double& k : arm.K) k = 500 * std::exp(random.normal());
  for (double& x : arm.q) x = random.normal();
  for (Index j = 0; j < n; ++j) arm.u[j] = arm.q[j] + 0.05 * random.normal();
  for (Index i = 0; i < arm.J.size(); ++i) arm.J.data()[i] = 0.4 * random.normal();
  return arm;
}

TEST(Equilibrium, TwoSpringsAtAWall_IsHooke) {
  // Two sliders of 1000 and 500 N/m; the first is stopped by a wall that pushes along −x.
  RowMatrix J(1, 2);
  J << -1, 0;
  Equilibrium out;
  ASSERT_EQ(calc_equilibrium(Eigen::Vector2d(1000, 500), J, Eigen::Vector2d(0, 0), Eigen::Vector2d(0.015, 0.02), out), Status::Solved);
  EXPECT_NEAR(out.lambda[0], 15, 1e-12);
  EXPECT_NEAR(out.q[0], 0, 1e-15);
  EXPECT_NEAR(out.q[1], 0.02, 1e-15);
}

/// (5.9) against the KKT system (5.8), solved as it stands.
TEST(Equilibrium, RandomArms_SolveTheKktSystem) {
  core::Random random(1, 0);
  for (int trial = 0; trial < 300; ++trial) {
    const Index n = 2 + random.index(8), m = 1 + random.index(static_cast<int>(std::min<Index>(n, 4)));
    const Arm arm = random_arm(random, n, m);
    Eigen::MatrixXd KKT = Eigen::MatrixXd::Zero(n + m, n + m);
    KKT.topLeftCorner(n, n) = arm.K.asDiagonal();
    KKT.topRightCorner(n, m) = -arm.J.transpose();
    KKT.bottomLeftCorner(m, n) = arm.J;
    VectorXd rhs(n + m);
    rhs << arm.K.cwiseProduct(arm.u), arm.J * arm.q;
    const VectorXd want = KKT.fullPivLu().solve(rhs);
    if (Eigen::MatrixXd(arm.J * arm.J.transpose()).fullPivLu().rcond() < 1e-4) continue;
    Equilibrium out;
    ASSERT_EQ(calc_equilibrium(arm.K, arm.J, arm.q, arm.u, out), Status::Solved);
    EXPECT_LE((out.q - want.head(n)).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE((out.lambda - want.tail(m)).cwiseAbs().maxCoeff(), 1e-8 * (1 + want.tail(m).cwiseAbs().maxCoeff()));
  }
}

/// The theorem of section 5.4.2: the stiffness-consistent projection is the dynamics (5.9), and of the weighted ones it alone moves no
/// contact point for any torque, (5.19).
TEST(StiffnessConsistentInverse, Projection_IsTheQuasiStaticModelAndIsUnique) {
  core::Random random(2, 0);
  for (int trial = 0; trial < 200; ++trial) {
    const Index n = 3 + random.index(6), m = 1 + random.index(2);
    const Arm arm = random_arm(random, n, m);
    Eigen::MatrixXd inverse;
    Equilibrium out;
    ASSERT_EQ(calc_stiffness_consistent_inverse(arm.K, arm.J, inverse), Status::Solved);
    ASSERT_EQ(calc_equilibrium(arm.K, arm.J, arm.q, arm.u, out), Status::Solved);
    const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(n, n);
    const double force = 1 + out.lambda.cwiseAbs().maxCoeff();
    EXPECT_LE((arm.q + (I - inverse * arm.J) * (arm.u - arm.q) - out.q).cwiseAbs().maxCoeff(), 1e-10);                       // (5.20)
    EXPECT_LE((-inverse.transpose() * arm.K.cwiseProduct(arm.u - arm.q) - out.lambda).cwiseAbs().maxCoeff(), 1e-9 * force);  // (5.21)
    const Eigen::MatrixXd P_N = I - arm.J.transpose() * inverse.transpose();                                                 // (5.10b)
    const Eigen::MatrixXd moved = arm.J * arm.K.cwiseInverse().asDiagonal() * P_N;
    EXPECT_LE(moved.cwiseAbs().maxCoeff() * arm.K.minCoeff(), 1e-10);
    const Eigen::MatrixXd plain = arm.J.transpose() * Eigen::MatrixXd(arm.J * arm.J.transpose()).inverse();  // W = I
    const Eigen::MatrixXd moved_by_plain = arm.J * arm.K.cwiseInverse().asDiagonal() * (I - arm.J.transpose() * plain.transpose());
    EXPECT_GT(moved_by_plain.cwiseAbs().maxCoeff() * arm.K.minCoeff(), 1e-6) << "any weight would do";
  }
}

TEST(Equilibrium, DependentContacts_AreRefused) {
  core::Random random(3, 0);
  Arm arm = random_arm(random, 5, 2);
  arm.J.row(1) = -arm.J.row(0);
  Equilibrium out;
  Eigen::MatrixXd inverse;
  EXPECT_EQ(calc_equilibrium(arm.K, arm.J, arm.q, arm.u, out), Status::NumericalFailure);
  EXPECT_EQ(calc_stiffness_consistent_inverse(arm.K, arm.J, inverse), Status::NumericalFailure);
  arm.K[2] = -1;
  EXPECT_NE(stiction::test::message_of([&] { (void)calc_equilibrium(arm.K, arm.J, arm.q, arm.u, out); }).find("K: got -1"),
            std::string::npos);
}

}  // namespace
}  // namespace stiction::control::test
