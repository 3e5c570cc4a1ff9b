#include "stiction/planning/thresholds.hpp"

#include <gtest/gtest.h>

#include "planning/systems.hpp"
#include "stiction/planning/sample_boxes.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning::test {
namespace {

world::Scene cube_scene(double length, double mass) {
  world::Scene scene;
  world::ObjectSpec cube;
  cube.name = "cube";
  cube.joint = world::ObjectJoint::Free;
  cube.mass = mass;
  cube.inertia = mass * length * length / 6 * Eigen::Matrix3d::Identity();
  cube.geometries = {{"g", world::Box{Eigen::Vector3d::Constant(0.5 * length)}, {}, 0.5}};
  scene.objects.push_back(cube);
  return scene;
}

TEST(SceneThresholds, InOtherUnits_TheSameUpToScale) {
  const auto of = [](double length, double mass) { return SceneThresholds(*world::Model::make(cube_scene(length, mass)), 0); };
  const SceneThresholds one = of(0.0625, 0.125);
  for (const double s : {0.03125, 8.0, 64.0}) {
    for (const double m : {0x1p-20, 1024.0}) {
      const SceneThresholds o = of(0.0625 * s, 0.125 * m);
      EXPECT_DOUBLE_EQ(o.gamma, one.gamma * s * s);
      EXPECT_DOUBLE_EQ(o.smoothing.kappa, one.smoothing.kappa / (m * s));
      EXPECT_DOUBLE_EQ(o.substep.slide, one.substep.slide * s);
      EXPECT_DOUBLE_EQ(o.substep.joint_travel, one.substep.joint_travel * s);
      EXPECT_DOUBLE_EQ(o.clearance, one.clearance * s);
      EXPECT_DOUBLE_EQ(o.release.position, one.release.position * s);
      EXPECT_DOUBLE_EQ(o.rest.position, one.rest.position * s);
      EXPECT_DOUBLE_EQ(o.preload, one.preload * m);
      EXPECT_DOUBLE_EQ(o.brace, one.brace * m);
      EXPECT_EQ(o.substep.joint_angle, one.substep.joint_angle);
    }
  }
}

TEST(SceneThresholds, OfACubeOfTenCentimetresAndAHundredGrams_AreThoseFoundByHand) {
  const SceneThresholds o(*world::Model::make(cube_scene(0.1, 0.1)), 0);
  EXPECT_NEAR(o.gamma, 1e-4, 1e-9);
  EXPECT_NEAR(o.substep.slide, 1e-3, 1e-9);
  EXPECT_NEAR(o.clearance, 2e-3, 1e-9);
  EXPECT_NEAR(o.smoothing.kappa, 2 / (0.03 * 0.1 * 0.981), 1e-6);
}

/// Upwards half of the way more, since what stands in the way is passed above.
TEST(DefaultSampleBoxes, HoldStartAndGoalAndSomeWayBeyond) {
  PlanningProblem problem;
  problem.model = world::Model::make(cube_scene(0.1, 1));
  problem.q_start.resize(7);
  problem.q_start << 1, 2, 3, 0, 0, 0, 1;
  problem.goal.X_WG.p = Eigen::Vector3d(1.4, 2, 3);
  problem.goal.X_WG.R = Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const auto boxes = default_sample_boxes(problem);
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_EQ(boxes[0].object, 0);
  Eigen::VectorXd lower(6), upper(6);
  lower << 1 - 0.1, 2 - 0.05, 3 - 0.05, -0.2, -0.2, -0.75;
  upper << 1.4 + 0.1, 2 + 0.05, 3 + 0.05 + 0.2, 0.2, 0.2, 3.75;
  EXPECT_TRUE(boxes[0].lower.isApprox(lower, 1e-9)) << boxes[0].lower.transpose();
  EXPECT_TRUE(boxes[0].upper.isApprox(upper, 1e-9)) << boxes[0].upper.transpose();
}

TEST(DefaultSampleBoxes, TheShortWayAroundAndTheRangesOfJoints) {
  world::Scene scene = cube_scene(0.1, 1);
  scene.objects[0].joint = world::ObjectJoint::Hinge;
  scene.objects[0].limits = {-1.0, 2.0};
  PlanningProblem door;
  door.model = world::Model::make(scene);
  door.q_start = Eigen::VectorXd::Zero(1);
  door.q_goal = Eigen::VectorXd::Ones(1);
  const world::SampleBox hinge = default_sample_boxes(door).at(0);
  EXPECT_EQ(hinge.lower[0], -1);
  EXPECT_EQ(hinge.upper[0], 2);
  PlanningProblem hand = hand_problem();  // a ball in a plane, turned from 0 to −3 rad by way of −π
  hand.q_start[2] = 3;
  hand.goal.X_WG.R = Eigen::AngleAxisd(-3, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const world::SampleBox ball = default_sample_boxes(hand).at(0);
  EXPECT_NEAR(ball.lower[2], 3 - 0.2, 1e-9);
  EXPECT_NEAR(ball.upper[2], 2 * std::numbers::pi - 3 + 0.2, 1e-9);
}

TEST(Planner, WithoutBoxesOrSettings_PlansThePlanarHand) {
  PlanningProblem problem = hand_problem();
  PlannerOptions options;
  options.threads = 2;
  PlanResult result;
  EXPECT_EQ(plan(problem, options, {}, result), core::Status::Solved) << result.reason;
}

}  // namespace
}  // namespace stiction::planning::test
