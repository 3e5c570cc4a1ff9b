// Commands of a refinement where motors cannot follow them.
#include "stiction/planning/refine/command_follower.hpp"

#include <gtest/gtest.h>

#include "planning/systems.hpp"

namespace stiction::planning::refinement {
namespace {

using Eigen::VectorXd;

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

/// A hand that is pressed on a table slides over its end: from there its command, which its motor held back, goes on in sub-steps.
TEST(CommandFollower, CommandHeldBackByAMotor_FollowsWithinTheSubStep) {
  const auto model = weak_hand_on_table();
  Plan plan;
  plan.q_start = (VectorXd(5) << 0, 3, 0, 0, 0.001).finished();
  plan.u_start = plan.q_start.tail(2);
  plan.step.effort_limits = true;
  plan.substep = {.joint_angle = 0.03, .joint_travel = 0.01, .slide = 1, .max_substeps = 400};
  plan.goal.X_WG = world::object_pose(*model, plan.q_start, 0);
  const PlannerOptions options;
  const RefineOptions refine_options;
  const core::RunControl control;
  const Problem problem(model, plan, options, refine_options, control);
  Scratch scratch(model, control);
  const StepSizes sizes(problem, 2);
  CommandFollower follower(problem, sizes, plan.q_start, plan.u_start, nullptr, scratch);
  Segment segment;
  ASSERT_TRUE(follower.advance_in_parts((VectorXd(2) << 0.3, -0.3).finished(), segment));
  VectorXd before = plan.u_start;
  bool held = false;
  for (const auto& knot : segment.knots) {
    EXPECT_LE((knot.u - before).cwiseAbs().maxCoeff(), sizes.limits[0] * (1 + 1e-9));
    held = held || knot.u[1] > before[1] - 1e-4;
    before = knot.u;
  }
  EXPECT_TRUE(held);
  EXPECT_LT(follower.q[1 + 3], -0.1) << "it went over the end, and down";
}

}  // namespace
}  // namespace stiction::planning::refinement
