#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <vector>

#include "control/random_tick.hpp"
#include "stiction/control/quasi_static.hpp"
#include "support/message_of.hpp"

namespace stiction::control::test {
namespace {

using core::Status;
using Eigen::Index;
using Eigen::VectorXd;
using stiction::test::message_of;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A finger on a slider of stiffness 1000 N/m; a wall pushes it back along −x.
RandomTick slider(double q, double q_cmd, double q_ref, double lambda) {
  RandomTick t;
  t.robot = {.stiffness = VectorXd::Constant(1, 1000),
             .rate = VectorXd::Constant(1, 1),
             .lower = VectorXd::Constant(1, -kInfinity),
             .upper = VectorXd::Constant(1, kInfinity),
             .torque = VectorXd::Constant(1, kInfinity)};
  t.q = VectorXd::Constant(1, q), t.q_cmd = VectorXd::Constant(1, q_cmd), t.q_ref = VectorXd::Constant(1, q_ref);
  t.J_u = RowMatrix::Constant(1, 1, -1);
  t.lambda = VectorXd::Constant(1, lambda), t.lambda_max = VectorXd::Constant(1, 15);
  return t;
}

ContactQpResult solve(const RandomTick& t, const ContactQpOptions& options = {}) {
  ContactQpWorkspace work;
  ContactQpResult out;
  EXPECT_EQ(solve_contact_qp(t.robot, t.input(), options, work, out), Status::Solved);
  return out;
}

TEST(ContactQp, WallInTheWay_CommandIsWhereTheSpringPushesWithTheBound) {
  // 15 N at 1000 N/m: 15 mm behind the wall, whatever the reference wants. Measured and modelled force agree.
  const ContactQpResult out = solve(slider(0, 0.015, 0.1, 15));
  EXPECT_NEAR(out.q_cmd[0], 0.015, 1e-6);
  EXPECT_NEAR(out.lambda[0], 15, 1e-3);
  EXPECT_NEAR(out.q_next[0], 0, 1e-6);
}

TEST(ContactQp, ReferenceNeedsLess_IsTracked) {
  const ContactQpResult out = solve(slider(0, 0.002, 0.01, 2));
  EXPECT_NEAR(out.q_cmd[0], 0.01, 1e-15);
  EXPECT_EQ(out.slack[0], 0);
}

TEST(ContactQp, ReferenceLeaves_IsTrackedAndMayPull) {
  const ContactQpResult out = solve(slider(0, 0.015, -0.02, 15));
  EXPECT_NEAR(out.q_cmd[0], -0.02, 1e-15);  // (5.30): not held back by λ ≥ 0
  EXPECT_LT(out.lambda[0], 0);
  EXPECT_EQ(out.pull[0], 0);
}

TEST(ContactQp, Damping_DividesTheChangeByOnePlusW) {
  RandomTick t = slider(0, 0.002, 0.01, 2);
  t.damping = 3;
  EXPECT_NEAR(solve(t).q_cmd[0], 0.002 + 0.008 / 4, 1e-15);
}

TEST(ContactQp, ForceAboveBoundAndSlowCommand_RateHoldsAndSlackIsReported) {
  RandomTick t = slider(0, 0.05, 0.1, 50);
  t.robot.rate[0] = 0.005;
  const ContactQpResult out = solve(t);
  EXPECT_EQ(out.q_cmd[0], 0.05 - 0.005);
  EXPECT_NEAR(out.lambda[0], (0.01 * 50 + 45) / 1.01, 1e-9);  // (C.4) by hand
  EXPECT_NEAR(out.slack[0], out.lambda[0] - 15, 1e-9);
  EXPECT_FALSE(out.within_limits(0.1));
}

TEST(ContactQp, LimitsInConflict_RateBeforeTorqueBeforeJointLimits) {
  RandomTick t = slider(0, 0.05, 0.05, 0);
  t.J_u.resize(0, 1), t.lambda.resize(0), t.lambda_max.resize(0);
  t.robot.torque[0] = 30;  // up to 30 mm from q
  t.robot.lower[0] = 0.04;
  ContactQpResult out = solve(t);
  EXPECT_NEAR(out.q_cmd[0], 0.03, 1e-15) << "torque before joint limits";
  EXPECT_NEAR(out.limit_slack[0], 0.01, 1e-15);
  EXPECT_EQ(out.torque_slack[0], 0);
  t.robot.rate[0] = 0.005;
  out = solve(t);
  EXPECT_EQ(out.q_cmd[0], 0.05 - 0.005) << "rate before torque";
  EXPECT_NEAR(out.torque_slack[0], 15, 1e-12);
  EXPECT_EQ(out.limit_slack[0], 0);
}

TEST(ContactQp, TwoOpposedContacts_ShareTheirSqueeze) {
  // A wedge between two walls, no joint in between: both forces are measured, neither can be changed by the command.
  RandomTick t = slider(0, 0, 0, 20);
  t.J_u.resize(2, 1);
  t.J_u << -1, 1;
  t.lambda = Eigen::Vector2d(20, 20), t.lambda_max = Eigen::Vector2d(15, 15);
  const ContactQpResult out = solve(t);
  EXPECT_NEAR(out.q_cmd[0], 0, 1e-9);
  EXPECT_NEAR(out.lambda[0], 20, 1e-6);
  EXPECT_NEAR(out.lambda[1], 20, 1e-6);
  EXPECT_NEAR(out.slack[0], 5, 1e-4);
  EXPECT_NEAR(out.slack[1], 5, 1e-4);
}

TEST(ContactQp, TwoEqualContacts_HaveTheForcesOfTheModelTogether) {
  RandomTick t = slider(0, 0.04, 0.1, 20);
  t.J_u = RowMatrix::Constant(2, 1, -1);
  t.lambda = Eigen::Vector2d(10, 30), t.lambda_max = Eigen::Vector2d(15, 40);
  const ContactQpResult out = solve(t);
  // λ₁ + λ₂ = 1000 x and λ₁ − λ₂ stays as measured: λ₁ reaches 15 N at λ₂ = 35 N.
  EXPECT_NEAR(out.lambda[0], 15, 2e-2);
  EXPECT_NEAR(out.lambda[1], 35, 2e-2);
  EXPECT_NEAR(out.q_cmd[0], 0.05, 2e-4);
}

/// Sets that exclude each other: forces of each are those of the program that knows no other, and no bound of any is broken.
TEST(ContactQp, ContactsOfSeveralGroups_AreJudgedAsIfTheOthersWereNotThere) {
  core::Random random(5, 0);
  int compared = 0, coupled = 0;
  for (int trial = 0; trial < 300; ++trial) {
    RandomTick t = random_tick(random);
    const Index m = t.J_u.rows();
    if (m < 4) continue;
    std::vector<int> groups(static_cast<std::size_t>(m), 2);
    groups[0] = groups[1] = 1;
    ContactQpInput in = t.input();
    in.groups = groups;
    ContactQpWorkspace work;
    ContactQpResult out;
    ASSERT_EQ(solve_contact_qp(t.robot, in, {}, work, out), Status::Solved);
    for (const auto& [first, count] : {std::pair<Index, Index>(0, 2), std::pair<Index, Index>(2, m - 2)}) {
      RandomTick one = t;  // held at the command that was found, so that only its forces are asked for
      one.J_u = t.J_u.middleRows(first, count).eval();
      one.lambda = t.lambda.segment(first, count).eval(), one.lambda_max = t.lambda_max.segment(first, count).eval();
      one.q_cmd = out.q_cmd;
      one.robot.rate.setConstant(1e-15), one.robot.torque.setConstant(kInfinity);
      one.robot.lower.setConstant(-kInfinity), one.robot.upper.setConstant(kInfinity);
      const ContactQpResult alone = solve(one);
      const double size = std::max(1.0, out.lambda.cwiseAbs().maxCoeff());
      EXPECT_LT((alone.lambda - out.lambda.segment(first, count)).cwiseAbs().maxCoeff(), 1e-8 * size);
      ++compared;
    }
    for (Index i = 0; i < m; ++i) EXPECT_LE(out.lambda[i], t.lambda_max[i] + out.slack[i] + 1e-9 * (1 + std::abs(out.lambda[i])));
    in.groups = {};
    ContactQpResult together;
    ASSERT_EQ(solve_contact_qp(t.robot, in, {}, work, together), Status::Solved);
    coupled += (together.lambda - out.lambda).cwiseAbs().maxCoeff() > 0.1;
  }
  EXPECT_GT(compared, 20);
  EXPECT_GT(coupled, compared / 4) << "groups make no difference";
}

TEST(ContactQp, NoContact_IsTheClampedAverage) {
  core::Random random(3, 0);
  for (int trial = 0; trial < 200; ++trial) {
    RandomTick t = random_tick(random);
    t.J_u.resize(0, t.q.size()), t.lambda.resize(0), t.lambda_max.resize(0);
    t.of_task = false;
    t.robot.lower.setConstant(-kInfinity), t.robot.upper.setConstant(kInfinity), t.robot.torque.setConstant(kInfinity);
    const ContactQpResult out = solve(t);
    for (Index j = 0; j < t.q.size(); ++j) {
      const double want = (t.q_ref[j] + t.damping * t.q_cmd[j]) / (1 + t.damping);
      EXPECT_NEAR(out.q_cmd[j], std::clamp(want, t.q_cmd[j] - t.robot.rate[j], t.q_cmd[j] + t.robot.rate[j]), 1e-14);
    }
  }
}

/// For C → 0 the predicted equilibrium is that of (5.9).
TEST(ContactQp, StiffContacts_PredictTheEquilibriumOfTheThesis) {
  core::Random random(4, 0);
  int compared = 0;
  for (int trial = 0; trial < 300; ++trial) {
    RandomTick t = random_tick(random);
    const Index m = t.J_u.rows();
    if (m == 0 || m > t.q.size()) continue;
    const VectorXd singular_values = Eigen::JacobiSVD<Eigen::MatrixXd>(t.J_u).singularValues();
    if (singular_values[m - 1] < 0.1 * singular_values[0]) continue;
    const ContactQpResult out = solve(t, {.contact_compliance = 1e-10});
    Equilibrium equilibrium;
    ASSERT_EQ(calc_equilibrium(t.robot.stiffness, t.J_u, t.q, out.q_cmd, equilibrium), Status::Solved);
    const double size = std::max(1.0, equilibrium.lambda.cwiseAbs().maxCoeff());
    EXPECT_LE((out.lambda - equilibrium.lambda).cwiseAbs().maxCoeff(), 1e-6 * size);
    EXPECT_LE((out.q_next - equilibrium.q).cwiseAbs().maxCoeff(), 1e-6);
    ++compared;
  }
  EXPECT_GT(compared, 50);
}

TEST(ContactQp, TaskReference_MovesTheToolAndLeavesTheRest) {
  core::Random random(6, 0);
  RandomTick t = random_tick(random);
  while (t.q.size() != 7) t = random_tick(random);
  t.J_u.resize(0, 7), t.lambda.resize(0), t.lambda_max.resize(0);
  t.of_task = true, t.damping = 0;
  t.q_cmd = t.q_ref = t.q;
  t.robot.rate.setConstant(10), t.robot.torque.setConstant(kInfinity);
  t.robot.lower.setConstant(-kInfinity), t.robot.upper.setConstant(kInfinity);
  const ContactQpResult out = solve(t, {.posture_weight = 1e-9});
  EXPECT_LE((t.task_jacobian * (out.q_cmd - t.q) - t.task_error).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(ContactQpProperty, RandomTicks_MeetTheOptimalityConditions) {
  core::Random random(7, 0);
  ContactQpWorkspace work;
  ContactQpResult out;
  int bounded = 0, conflicts = 0, most_iterations = 0;
  for (int trial = 0; trial < 100000; ++trial) {
    const RandomTick t = random_tick(random);
    ContactQpOptions options;
    options.cost = trial % 3 == 0 ? TrackingCost::Equilibrium : TrackingCost::Command;
    options.unilateral = !t.of_task;  // the residual knows (5.30) of joint references
    ASSERT_EQ(solve_contact_qp(t.robot, t.input(), options, work, out), Status::Solved) << trial;
    ASSERT_LE(kkt_residual(t, options, out, work.solution), 1e-8) << trial;
    const Index m = t.J_u.rows();
    most_iterations = std::max(most_iterations, out.iterations);
    if (m == 0) continue;
    bounded += (out.lambda - t.lambda_max).maxCoeff() > -1e-6;
    conflicts += out.slack.maxCoeff() > 1e-2;
    ASSERT_LE((out.lambda - t.lambda_max - out.slack).maxCoeff(), 1e-8 * std::max(1.0, out.lambda.cwiseAbs().maxCoeff())) << trial;
  }
  EXPECT_GT(bounded, 20000);
  EXPECT_GT(conflicts, 10000);
  EXPECT_LT(most_iterations, 60);
}

TEST(ContactQpInput, BadNumbers_AreNamed) {
  RandomTick t = slider(0, 0, 0, 1);
  ContactQpWorkspace work;
  ContactQpResult out;
  const auto message = [&] { return message_of([&] { (void)solve_contact_qp(t.robot, t.input(), {}, work, out); }); };
  EXPECT_EQ(message(), "no exception");
  t.lambda_max[0] = 0;
  EXPECT_NE(message().find("lambda_max: got 0"), std::string::npos) << message();
  t.lambda_max[0] = 15, t.q[0] = std::nan("");
  EXPECT_NE(message().find("q[0]: got nan"), std::string::npos) << message();
  t.q[0] = 0, t.damping = -1;
  EXPECT_NE(message().find("damping: got -1"), std::string::npos) << message();
  t.damping = 0, t.J_u.resize(1, 2), t.J_u.setZero();
  EXPECT_NE(message().find("J_u.cols"), std::string::npos) << message();
  RobotLimits robot = slider(0, 0, 0, 1).robot;
  robot.stiffness[0] = 0;
  EXPECT_NE(message_of([&] { robot.validate(); }).find("stiffness: got 0"), std::string::npos);
}

}  // namespace
}  // namespace stiction::control::test
