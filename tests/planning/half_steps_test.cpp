// What is met at half sub-steps.
#include "stiction/planning/refine/half_steps.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "planning/systems.hpp"
#include "stiction/planning/force_gap.hpp"

namespace stiction::planning::refinement {
namespace {

using Eigen::VectorXd;

constexpr double kAnything = std::numeric_limits<double>::infinity();

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
  const PlannerOptions options;
  const RefineOptions refine_options;
  const core::RunControl control;
  const Problem problem(model, plan, options, refine_options, control);
  Scratch scratch(model);
  const auto go = [&](double penetration) {
    HalfSteps at{.q = plan.q_start, .u = plan.u_start, .worst = {}};
    Work work;
    const bool good = go_on_in_half_steps(problem, segments, plan.step, {penetration, kAnything, kAnything}, {}, scratch, at, work);
    EXPECT_EQ(work.steps, 2);
    EXPECT_GT(at.q[2], 0.5) << "the box turns";
    EXPECT_EQ(at.worst.penetration > penetration, !good);
    return at.worst.penetration;
  };
  EXPECT_GT(go(kAnything), kMostPenetration);
  EXPECT_GT(go(kMostPenetration), kMostPenetration);
}

}  // namespace
}  // namespace stiction::planning::refinement
