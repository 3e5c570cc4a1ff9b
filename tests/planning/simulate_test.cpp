// Commands simulated with the exact dynamics, and what ends that.
#include "stiction/planning/simulate.hpp"

#include <gtest/gtest.h>

#include "planning/systems.hpp"
#include "stiction/planning/contact_limits.hpp"

namespace stiction::planning {
namespace {

using Eigen::VectorXd;

/// The hand comes to the end of the box in the first half of a sub-step and turns it in the second: a side that turns over a ball ends inside it, by ½ θ² of its
/// radius. No step starts from there, and the checker looks all the same.
TEST(Simulation, LastState_IsLookedAt) {
  world::Scene scene = test::load_model("planar_pushing")->scene();
  scene.robots[0].friction = 0;  // no gap of Anitescu's law
  const auto model = world::Model::make(scene);
  Plan plan;
  plan.q_start = (VectorXd(5) << 0, 0.6, 0, 0.45, -0.5).finished();
  plan.u_start = plan.q_start.tail(2);
  plan.substep = {.joint_angle = 0.03, .joint_travel = 0.03, .slide = 2e-3, .max_substeps = 400};
  plan.goal.X_WG = world::object_pose(*model, plan.q_start, 0);
  dynamics::Knot up;
  up.u = (VectorXd(2) << 0.45, 0.5).finished();
  PlannerOptions options;
  const Setting setting({.model = model, .q_start = plan.q_start, .goal = plan.goal, .q_goal = {}}, options);
  const core::RunControl control;
  SimulationScratch scratch(model, control);
  const auto go = [&](double penetration) {
    Trace at{.q = plan.q_start, .u = plan.u_start};
    Work work;
    const Watch watch{.most = {penetration, kUnlimited, kUnlimited}};
    Simulation simulation(setting, scratch, work);
    const bool good = simulation.follow(up.u, half_steps(setting), watch, at) == Ending::Reached && simulation.ends_well(watch, at);
    EXPECT_EQ(work.steps, 2);
    EXPECT_GT(at.q[2], 0.5) << "the box turns";
    EXPECT_EQ(at.worst.penetration > penetration, !good);
    return at.worst.penetration;
  };
  EXPECT_GT(go(10), kMostPenetration);
  EXPECT_GT(go(kMostPenetration), kMostPenetration);
}

/// planar_pushing with a weak hand above a table, which ends 5 cm beside it; the box is out of the way.
std::shared_ptr<const world::Model> weak_hand_on_table() {
  world::Scene scene = test::load_model("planar_pushing")->scene();
  scene.robots[0].effort = {{"y", 100.0}, {"z", 3.0}};
  world::FixedSpec table;
  table.name = "table";
  table.X_WB.p = {0, -0.45, -0.6};  // its end at y = 0.05, its top at z = −0.1
  table.geometries.push_back({.name = "box", .shape = world::Box{Eigen::Vector3d::Constant(0.5)}, .X_BG = {}, .friction = 0});
  scene.fixed.push_back(table);
  return world::Model::make(scene);
}

/// The problem of a plan from q, in which the box may be anywhere.
struct Rig {
  Rig(std::shared_ptr<const world::Model> shared, VectorXd q)
      : model(std::move(shared)),
        setting({.model = model, .q_start = q, .goal = {.X_WG = world::object_pose(*model, q, 0)}, .q_goal = {}}, options),
        scratch(model, control) {}

  std::shared_ptr<const world::Model> model;
  PlannerOptions options;
  Setting setting;
  core::RunControl control;
  SimulationScratch scratch;
  Work work;
};

/// A hand that is pressed on a table slides over its end: from there its command, which its motor held back, goes on in sub-steps.
TEST(Simulation, CommandHeldBackByAMotor_FollowsWithinTheSubStep) {
  Rig rig(weak_hand_on_table(), (VectorXd(5) << 0, 3, 0, 0, 0.001).finished());
  Pace pace = substeps(rig.setting);
  pace.limits = {.joint_angle = 0.03, .joint_travel = 0.01, .slide = 1, .max_substeps = 400};
  Trace at{.q = rig.setting.problem.q_start, .u = rig.setting.problem.q_start.tail(2)};
  VectorXd before = at.u;
  ASSERT_EQ(Simulation(rig.setting, rig.scratch, rig.work).follow((VectorXd(2) << 0.3, -0.3).finished(), pace, {}, at), Ending::Reached);
  bool held = false;
  for (const auto& knot : at.knots) {
    EXPECT_LE((knot.u - before).cwiseAbs().maxCoeff(), pace.limits.joint_travel * (1 + 1e-9));
    held = held || knot.u[1] > before[1] - 1e-4;
    before = knot.u;
  }
  EXPECT_TRUE(held);
  EXPECT_LT(at.q[1 + 3], -0.1) << "it went over the end, and down";
}

/// The hand below the box pushes it up by 0.1 m.
struct PushUp : Rig {
  PushUp() : Rig(test::load_model("planar_pushing"), (VectorXd(5) << 0, 0.6, 0, 0, -0.02).finished()) {}
  Ending go(const Watch& watch, Trace& at) {
    at = {.q = setting.problem.q_start, .u = setting.problem.q_start.tail(2)};
    return Simulation(setting, scratch, work).follow((VectorXd(2) << 0, 0.1).finished(), substeps(setting), watch, at);
  }
};

TEST(Simulation, ObjectThatLeavesItsPlace_EndsTheSimulationAtTheLastAllowedState) {
  PushUp rig;
  Trace free, at;
  ASSERT_EQ(rig.go({}, free), Ending::Reached);
  ASSERT_GT(free.q[1], 0.65) << "the box was pushed";
  const VectorXd& start = rig.setting.problem.q_start;
  const Watch watch{.places = {{{&start, {0.02, 1}}, {}}}};
  EXPECT_EQ(rig.go(watch, at), Ending::Moved);
  EXPECT_LE(at.q[1], 0.62 + 1e-9);
  EXPECT_LT(at.knots.size(), free.knots.size());
  const Watch either{.places = {{{&start, {0.02, 1}}, {&free.q, {0.2, 1}}}}};
  EXPECT_EQ(rig.go(either, at), Ending::Reached) << "it may be at the second place as well";
}

TEST(Simulation, Hold_EndsWhenTheObjectsRest) {
  PushUp rig;
  Trace at;
  ASSERT_EQ(rig.go({}, at), Ending::Reached);
  bool rests = false;
  at.knots.clear();
  Simulation simulation(rig.setting, rig.scratch, rig.work);
  ASSERT_EQ(simulation.hold(50, rig.setting.thresholds.rest, substeps(rig.setting), {}, {}, at, rests), Ending::Reached);
  EXPECT_TRUE(rests);
  EXPECT_LT(at.knots.size(), 50U);
  const VectorXd q = at.q;
  ASSERT_EQ(simulation.hold(1, rig.setting.thresholds.rest, substeps(rig.setting), {}, {}, at, rests), Ending::Reached);
  const Allowance& rest = rig.setting.thresholds.rest;
  EXPECT_LE(rig.setting.goal.share(q, at.q, rest.position, rest.angle), 1);
}

TEST(Simulation, StoppedRun_EndsBeforeTheNextCommand) {
  PushUp rig;
  const std::atomic<bool> cancel{true};
  rig.control.cancel = &cancel;
  Trace at;
  EXPECT_EQ(rig.go({}, at), Ending::Stopped);
  EXPECT_TRUE(at.knots.empty());
}

}  // namespace
}  // namespace stiction::planning
