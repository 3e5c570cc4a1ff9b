// Balls in which points stay, and pairs that never meet.
#include "stiction/world/reach_ball.hpp"

#include <algorithm>

#include "world/gripper.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world::test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Coordinates with limits are within them.
VectorXd random_within_limits(const Model& model, core::Random& random) {
  VectorXd q = random_configuration(model, random, 2);
  for (const ObjectInfo& object : model.objects()) {
    const Dof& dof = model.dofs()[static_cast<std::size_t>(object.v_begin)];
    if (object.n_v == 1) q[object.q_begin] = std::clamp(q[object.q_begin], dof.lower, dof.upper);
  }
  q.tail(model.n_a()) = q.tail(model.n_a()).cwiseMax(model.lower()).cwiseMin(model.upper()).eval();
  return q;
}

/// Of scenes with every kind of joint: joints that follow others, linked objects, a gripper on sliders.
TEST(ReachBall, Points_StayWithin) {
  const RobotFolder folder;
  Scene drawers = make_linked();
  for (ObjectSpec& object : drawers.objects) {
    if (object.joint == ObjectJoint::Slider) object.limits = {-0.1, 0.4};
  }
  for (const auto& model : {Model::make(drawers), make_gripper(folder, 0.1), load_task("allegro_cube")}) {
    core::Random random(3, 0);
    KinematicsWorkspace work(*model);
    Kinematics first, kinematics;
    const VectorXd q_first = random_within_limits(*model, random);
    calc_kinematics(*model, q_first, work, first);
    double widest = 0;  // share of its ball that a point uses
    for (int i = 0; i < 300; ++i) {
      const VectorXd q = random_within_limits(*model, random);
      calc_kinematics(*model, q, work, kinematics);
      for (const Body& body : model->bodies()) {
        const auto b = static_cast<std::size_t>(&body - model->bodies().data());
        const Vector3d p_B(0.03, -0.02, 0.05);
        const Ball ball = calc_reach_ball(model->impl(), first, q_first, body, first.X_WB[b] * p_B);
        const double off = (kinematics.X_WB[b] * p_B - ball.center).norm();
        EXPECT_LE(off, ball.radius + 1e-9) << body.name;
        if (ball.radius > 0 && std::isfinite(ball.radius)) widest = std::max(widest, off / ball.radius);
      }
    }
    EXPECT_GT(widest, 0.9);
  }
}

TEST(ReachBall, FreeObjects_AreAnywhere_AndStandStillForRobotsAlone) {
  const auto model = load_task("allegro_cube");
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  const VectorXd q = model->neutral();
  calc_kinematics(*model, q, work, kinematics);
  const Body& cube = model->bodies()[static_cast<std::size_t>(model->objects()[0].body)];
  EXPECT_FALSE(std::isfinite(calc_reach_ball(model->impl(), kinematics, q, cube, Vector3d::Zero()).radius));
  const std::vector<char> joints(static_cast<std::size_t>(model->n_a()), 1);
  EXPECT_EQ(calc_reach_ball(model->impl(), kinematics, q, cube, Vector3d::Zero(), joints).radius, 0);
}

/// An arm that turns by a ball of 0.1 m around the vertical, at 0.5 m from the axis; contacts are looked for within 25 mm.
std::size_t pairs_of_arm(const RobotFolder& folder, const std::string& shape, const Vector3d& place) {
  folder.write("arm.urdf", R"(<robot name="arm"><link name="base"/><link name="hand"><collision><origin xyz="0.5 0 0"/><geometry>
<sphere radius="0.1"/></geometry></collision></link><joint name="turn" type="continuous"><parent link="base"/><child link="hand"/>
<axis xyz="0 0 1"/></joint></robot>)");
  const std::string text = fmt::format(R"(
contact_distance: 0.025
robots: [{{name: r, urdf: arm.urdf}}]
fixed: [{{name: there, pose: {{position: [{}, {}, {}]}}, shapes: [{}]}}]
)",
                                       place.x(), place.y(), place.z(), shape);
  return Model::make(parse_scene(text, folder.path()))->pairs().size();
}

TEST(Pairs, WhatNeverMeets_IsNoPair) {
  const RobotFolder folder;
  // The ball of the hand's centre has 0.5 m, and 1.1 of it is within reach.
  EXPECT_EQ(pairs_of_arm(folder, "{sphere: {radius: 0.2}}", {0.87, 0, 0}), 1);
  EXPECT_EQ(pairs_of_arm(folder, "{sphere: {radius: 0.2}}", {0.88, 0, 0}), 0);
  EXPECT_EQ(pairs_of_arm(folder, "{half_space: {}}", {0, 0, -0.67}), 1);
  EXPECT_EQ(pairs_of_arm(folder, "{half_space: {}}", {0, 0, -0.68}), 0);
  // A long wall counts by its own faces and corners, not by the ball around it.
  EXPECT_EQ(pairs_of_arm(folder, "{box: {size: [0.2, 4, 4]}}", {0.77, 0, 0}), 1);
  EXPECT_EQ(pairs_of_arm(folder, "{box: {size: [0.2, 4, 4]}}", {0.78, 0, 0}), 0);
  EXPECT_EQ(pairs_of_arm(folder, "{box: {size: [1, 1, 4]}}", {0.97, 0.97, 0}), 1);
  EXPECT_EQ(pairs_of_arm(folder, "{box: {size: [1, 1, 4]}}", {0.98, 0.98, 0}), 0);
}

}  // namespace
}  // namespace stiction::world::test
