// What is met at half sub-steps.
#include "stiction/planning/edge_simulator.hpp"

#include <gtest/gtest.h>

#include "planning/systems.hpp"
#include "stiction/planning/contact_limits.hpp"

namespace stiction::planning {
namespace {

using Eigen::VectorXd;

/// The hand comes to the end of the box in the first half of a sub-step and turns it in the second: a side that turns over a ball ends inside it, by ½ θ² of its
/// radius. No step starts from there, and the checker looks all the same.
TEST(HalfSteps, LastState_IsLookedAt) {
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
  const std::vector<Segment> segments{{SegmentKind::Contact, {up}}};
  const world::RobotChains chains(*model);
  const PressLimits press(*model, chains, kUnlimited);
  const core::RunControl control;
  SimulationScratch scratch(model, control);
  dynamics::StepOptions cold = plan.step;
  cold.warm_start = false;
  const auto go = [&](double penetration) {
    HalfSteps at{.q = plan.q_start, .u = plan.u_start};
    Work work;
    const bool good = go_on_in_half_steps(press, segments, cold, {penetration, kUnlimited, kUnlimited}, control, scratch, at, work);
    EXPECT_EQ(work.steps, 2);
    EXPECT_GT(at.q[2], 0.5) << "the box turns";
    EXPECT_EQ(at.worst.penetration > penetration, !good);
    return at.worst.penetration;
  };
  EXPECT_GT(go(kUnlimited), kMostPenetration);
  EXPECT_GT(go(kMostPenetration), kMostPenetration);
}

}  // namespace
}  // namespace stiction::planning
