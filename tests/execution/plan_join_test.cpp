#include "stiction/execution/closed_loop/plan_join.hpp"

#include <gtest/gtest.h>

#include "planning/push_plan.hpp"
#include "stiction/execution/closed_loop/pose_tracker.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::VectorXd;
using planning::test::load_model;

/// The plan that pushes a box up by 0.2 m in two edges, and a state beside its middle.
struct PushUp {
  std::shared_ptr<const world::Model> model = load_model("planar_pushing");
  planning::Plan plan = planning::test::push_up(model);
  VectorXd q = plan.segments[0].knots.back().q, u = plan.segments[0].knots.back().u;

  Join join(const JoinOptions& options = {}) { return join_plan(model, plan, q, u, options); }
};

TEST(PlanJoin, StateBesideAPlace_GoesOnToTheGoal) {
  PushUp rig;
  rig.q[1] -= 0.004;  // a fifth of the tolerance lower, which the push takes along
  rig.q[4] -= 0.004;
  const Join join = rig.join();
  ASSERT_EQ(join.status, Status::Solved);
  EXPECT_EQ(join.segment, 1);
  EXPECT_LE(join.share, 0.5);
  EXPECT_EQ(join.plan.q_start, rig.q);
  EXPECT_EQ(join.plan.u_start, rig.u);
  EXPECT_GT(join.steps, 0);
  // The commands anew, step by step, from the state that was given.
  VectorXd q = rig.q;
  dynamics::StepWorkspace work(rig.model);
  dynamics::StepResult out;
  for (const auto& segment : join.plan.segments) {
    for (const auto& knot : segment.knots) {
      ASSERT_EQ(dynamics::step(*rig.model, {q, knot.u}, rig.plan.step, work, out), Status::Solved);
      q = out.q_next;
    }
  }
  EXPECT_LE(planning::goal_error(*rig.model, q, rig.plan.goal).share(rig.plan.goal), 0.5);
}

/// What is aside of a push stays aside: the plan does not lead to the goal, and the best of it is told.
TEST(PlanJoin, StateAside_DoesNotJoin) {
  PushUp rig;
  rig.q[0] += 1.5 * rig.plan.goal.tol_position;
  const Join aside = rig.join();
  EXPECT_NE(aside.status, Status::Solved);
  EXPECT_NEAR(aside.share, 1.5, 0.5);
  rig.q[0] += 2 * rig.plan.goal.tol_position;
  const Join far = rig.join();
  EXPECT_NE(far.status, Status::Solved);
  EXPECT_EQ(far.steps, 0) << "no place is that near";
  EXPECT_TRUE(std::isinf(far.share));
}

TEST(PlanJoin, RobotElsewhere_DoesNotJoin) {
  PushUp rig;
  rig.q.tail(2) << 2, 0.5;
  rig.u = rig.q.tail(2);
  EXPECT_NE(rig.join().status, Status::Solved);
}

/// The step with the command that the tracker gives brings the box nearer to where the plan has it; what is far off bounds the command.
TEST(PoseTracker, CommandsBesideThePlan_BringTheObjectBack) {
  PushUp rig;
  dynamics::StepWorkspace work(rig.model);
  dynamics::StepResult out;
  const auto height_after = [&](const VectorXd& u) {
    work.forget();
    EXPECT_EQ(dynamics::step(*rig.model, {rig.q, u}, rig.plan.step, work, out), Status::Solved);
    return out.q_next[1];
  };
  PoseTracker tracker(rig.model, rig.plan.goal, rig.plan.step);
  VectorXd wanted = rig.q;
  wanted[1] = height_after(rig.u) + 0.01;
  for (int k = 0; k < 5; ++k) ASSERT_EQ(tracker.update(rig.q, wanted, rig.u), Status::Solved);
  EXPECT_GT(tracker.delta()[1], 1e-3);
  EXPECT_LT(std::abs(height_after(rig.u + tracker.delta()) - wanted[1]), 0.007);

  wanted[1] += 10;
  for (int k = 0; k < 50; ++k) ASSERT_EQ(tracker.update(rig.q, wanted, rig.u), Status::Solved);
  EXPECT_NEAR(tracker.delta()[1], 0.15 * rig.model->scales().joints()[1], 1e-9);
  const VectorXd before = tracker.delta();
  tracker.fade((VectorXd(2) << 0, 1).finished(), 0.25);
  EXPECT_EQ(tracker.delta()[0], before[0]);
  EXPECT_NEAR(tracker.delta()[1], 0.75 * before[1], 1e-12);
}

TEST(PlanJoin, StepsAreBounded) {
  PushUp rig;
  const long all = rig.join().steps;
  const Join join = rig.join({.max_steps = all / 3});
  EXPECT_NE(join.status, Status::Solved);
  EXPECT_LT(join.steps, all);
}

}  // namespace
}  // namespace stiction::execution::test
