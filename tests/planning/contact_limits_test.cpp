// Gaps across which forces act, as `check` measures them.
#include "stiction/planning/contact_limits.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "dynamics/systems.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning::test {
namespace {

using Eigen::VectorXd;

/// A cube of 0.1 m stands on one of its edges, 1 mm from where the block below it ends.
world::Scene cube_on_block() {
  world::Scene scene = dynamics::test::empty_scene();
  scene.gravity = {0, 0, -9.81};
  world::ObjectSpec cube = dynamics::test::ball(world::ObjectJoint::PlanarYZ, 1, 0.05, 0);
  const world::Pose turned{Eigen::AngleAxisd(std::numbers::pi / 4, Eigen::Vector3d::UnitX()).toRotationMatrix(), Eigen::Vector3d::Zero()};
  cube.name = "cube";
  cube.geometries = {{.name = "cube", .shape = world::Box{Eigen::Vector3d::Constant(0.05)}, .X_BG = turned, .friction = 0}};
  scene.objects.push_back(cube);
  world::FixedSpec block;
  block.name = "block";
  block.X_WB.p = {0, -0.5, -0.5};
  block.geometries.push_back({.name = "box", .shape = world::Box{Eigen::Vector3d::Constant(0.5)}, .X_BG = {}, .friction = 0});
  scene.fixed.push_back(block);
  scene.robots.push_back(dynamics::test::pusher());
  return scene;
}

/// The linear gap of the step is none: it says nothing of the way over the end of the block, from where the side of the cube rises at 45°.
TEST(ForceGap, EdgeThatSlidesOverAnEnd_IsAsFarAwayAsItIs) {
  const auto model = world::Model::make(cube_on_block());
  dynamics::StepWorkspace work(model);
  dynamics::StepResult step;
  contact::GeometryWorkspace geometry(*model);
  VectorXd q = model->neutral(), aside = VectorXd::Zero(model->n_v());
  q.head(3) << -1e-3, 0.05 * std::numbers::sqrt2, 0;
  q.tail(2) << 2, 2;
  const auto push = [&](double force) {
    aside[0] = force;
    EXPECT_EQ(dynamics::step(*model, {q, q.tail(2), &aside}, {}, work, step), core::Status::Solved);
    return step.q_next[0] - q[0];
  };
  push(3e-3 / push(1e-3) * 1e-3);
  ASSERT_NEAR(step.q_next[0], 2e-3, 1e-5) << "2 mm over the end";
  double force = 0, linear = 0;
  for (const auto& c : step.contacts) {
    if (!c.active) continue;
    force = std::max(force, c.lambda[0] / 0.1);
    linear = std::max(linear, std::abs(c.anitescu_gap()) / model->scales().contact_tolerance(c.contact.pair));
  }
  EXPECT_GT(force, 1);
  EXPECT_LT(linear, 0.1);
  EXPECT_NEAR(calc_force_gap(*model, step.q_next, step.contacts, geometry), std::numbers::sqrt2, 0.02) << "of 1 mm";
}

}  // namespace
}  // namespace stiction::planning::test
