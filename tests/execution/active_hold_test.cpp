#include "stiction/execution/closed_loop/active_hold.hpp"

#include <gtest/gtest.h>

#include "cone_allocations.hpp"
#include "planning/push_plan.hpp"
#include "stiction/execution/closed_loop/simulated_plant.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::VectorXd;
using planning::test::allegro_start;
using planning::test::load_model;

constexpr double kPeriod = 0.01;

TEST(Fingers, AreTheBranchesOfAHandAndNotOfArms) {
  const auto hand = load_model("allegro_ball");
  const Fingers fingers = find_fingers(*hand, 0);
  EXPECT_EQ(fingers.joints.size(), 16U);
  ASSERT_EQ(fingers.pairs.size(), 4U);
  for (const auto& pairs : fingers.pairs) {
    ASSERT_FALSE(pairs.empty());
    for (const int pair : pairs) EXPECT_EQ(hand->geometries()[hand->pairs()[pair].geometry_a].name, "ball/ball");
  }
  for (const char* task : {"planar_hand", "planar_pushing", "allegro_door", "iiwa_bimanual"})
    EXPECT_TRUE(find_fingers(*load_model(task), 0).joints.empty()) << task << ": arms, or an object on a joint";
}

/// How far a ball in the open hand got [m], 3 s after a push of 0.1 s aside. @param force_W  [N]; the ball weighs 0.5 N
double roll(const std::shared_ptr<const world::Model>& model, const Eigen::Vector3d& force_W, bool active) {
  const VectorXd q = allegro_start();
  SimulatedPlant plant(model, q, {.pushes = {{.object = 0, .begin = 0.3, .duration = 0.1, .force_W = force_W}}});
  ActiveHold hold(model, 0, 0.7);
  hold.start(q);
  VectorXd u = plant.world().u();
  Measurement measured;
  while (plant.world().time() < 3.4) {
    EXPECT_TRUE(plant.read(measured));
    EXPECT_TRUE(!active || hold.update(measured.q, kPeriod, u) == Status::Solved);
    EXPECT_TRUE(plant.command(u, kPeriod));
  }
  return (plant.world().q().head<3>() - q.head<3>()).norm();
}

TEST(ActiveHold, BallThatIsPushedAside_StaysInTheHandThatItRollsOutOfAlone) {
  const auto model = load_model("allegro_ball");
  for (const Eigen::Vector3d& force : {Eigen::Vector3d(0.2, 0, 0), Eigen::Vector3d(0, -0.2, 0)}) {
    EXPECT_GT(roll(model, force, false), 0.1) << "it stays by itself: the test would say nothing";
    EXPECT_LT(roll(model, force, true), 1e-3);
  }
}

/// A hand with the ball at rest in it, and what hold does from there.
struct Rig {
  std::shared_ptr<const world::Model> model = load_model("allegro_ball");
  VectorXd q = allegro_start();
  VectorXd u = q.tail(16);
  ActiveHold hold{model, 0, 0.7};
};

TEST(ActiveHold, CommandsKeepToTheirRateAndToTheMotors) {
  Rig rig;
  VectorXd aside = rig.q;
  aside[0] += 0.02;  // two s: the reference comes along
  rig.hold.start(rig.q);
  const VectorXd strain = 0.9 * rig.model->effort().cwiseQuotient(rig.model->stiffness());
  bool fast = false;
  for (int k = 0; k < 200; ++k) {
    const VectorXd before = rig.u;
    ASSERT_EQ(rig.hold.update(aside, kPeriod, rig.u), Status::Solved);
    const VectorXd step = (rig.u - before).cwiseAbs();
    EXPECT_LE(step.maxCoeff(), 0.5 * kPeriod + 1e-12);
    fast = fast || step.maxCoeff() > 0.49 * kPeriod;
    EXPECT_LE(((rig.u - aside.tail(16)).cwiseAbs() - strain).maxCoeff(), 1e-12);
    EXPECT_TRUE((rig.u.array() >= rig.model->lower().array() - 1e-12).all() && (rig.u.array() <= rig.model->upper().array() + 1e-12).all());
  }
  EXPECT_TRUE(fast) << "nothing bounded it: the test would say nothing";
}

/// The cost (E.21) from exact steps with other commands, no derivative in it: the way that hold takes lessens it, the way back does not.
TEST(ActiveHold, ItsWayBringsTheBallBackInTheStepItself) {
  Rig rig;
  VectorXd aside = rig.q;
  aside[1] += 0.004;
  rig.hold.start(rig.q);
  VectorXd u = rig.u;
  for (int k = 0; k < 30; ++k) ASSERT_EQ(rig.hold.update(aside, kPeriod, u), Status::Solved);
  dynamics::StepWorkspace work(rig.model);
  dynamics::StepResult out;
  const auto distance = [&](const VectorXd& command) {
    work.forget();
    EXPECT_EQ(dynamics::step(*rig.model, {aside, command}, {.friction_scale = 0.7}, work, out), Status::Solved);
    return (out.q_next.head<3>() - rig.q.head<3>()).norm();
  };
  EXPECT_LT(distance(u), distance(rig.u) - 1e-4);
  EXPECT_GE(distance(2 * rig.u - u), distance(rig.u) - 1e-5);
}

TEST(ActiveHold, AfterTheFirstTicks_NothingIsAllocated) {
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  Rig rig;
  rig.hold.start(rig.q);
  long before = 0;
  for (int k = 0; k < 60; ++k) {
    if (k == 30) before = bench::allocations();
    VectorXd& q = rig.q;
    q[1] += k % 2 == 0 ? 1e-3 : -1e-3;
    ASSERT_EQ(rig.hold.update(q, kPeriod, rig.u), Status::Solved);
  }
  EXPECT_EQ(bench::allocations(), before);
}

TEST(ActiveHold, EqualInputsGiveEqualBits) {
  Rig a, b;
  a.hold.start(a.q), b.hold.start(b.q);
  for (int k = 0; k < 5; ++k) {
    ASSERT_EQ(a.hold.update(a.q, kPeriod, a.u), Status::Solved);
    ASSERT_EQ(b.hold.update(b.q, kPeriod, b.u), Status::Solved);
  }
  EXPECT_EQ(a.u, b.u);
  EXPECT_NE(a.u, a.q.tail(16));
}

}  // namespace
}  // namespace stiction::execution::test
