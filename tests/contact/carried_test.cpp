#include "stiction/contact/carried.hpp"

#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "stiction/world/read.hpp"

namespace stiction::contact::test {
namespace {

using Eigen::VectorXd;

/// A finger that slides along x, two cubes of 0.1 m over the ground, and a flap on a hinge.
std::shared_ptr<const world::Model> make_model(const std::string& gravity) {
  return world::Model::make(world::parse_scene(
      "gravity: " + gravity +
          "\n"
          "robots: [{name: r, mjcf: \"<mujoco><worldbody><body><joint name='x' type='slide' axis='1 0 0' range='-2 2'/><geom type='sphere' "
          "size='.02' mass='1'/></body></worldbody><actuator><position joint='x' kp='1000'/></actuator></mujoco>\"}]\n"
          "objects:\n"
          "  - {name: a, joint: free, mass: 0.2, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}\n"
          "  - {name: b, joint: free, mass: 0.2, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}\n"
          "  - {name: flap, joint: hinge, axis: [0, 1, 0], pose: {position: [5, 0, 1]}, mass: 0.2, shapes: [{box: {size: [0.1, 0.1, "
          "0.1]}}]}\n"
          "fixed: [{name: ground, shapes: [{half_space: {}}]}]\n",
      "."));
}

bool any(const world::Model& model, double z_a, double z_b) {
  VectorXd q = model.neutral();
  q[model.objects()[0].q_begin + 2] = z_a;
  q[model.objects()[1].q_begin + 2] = z_b;
  world::KinematicsWorkspace kinematics_work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, kinematics_work, kinematics);
  Workspace work(model);
  return Carried(model).any(kinematics, work);
}

TEST(Carried, AnObjectThatTouchesNeitherTheGroundNorAnotherObject) {
  const auto model = make_model("[0, 0, -9.81]");
  EXPECT_FALSE(any(*model, 0.05, 0.15)) << "one stands on the other, which stands on the ground";
  EXPECT_TRUE(any(*model, 0.3, 0.05)) << "one aloft, the other on the ground";
  EXPECT_TRUE(any(*model, 0.05, 0.3));
  EXPECT_FALSE(any(*model, 0.0505, 0.151)) << "gaps below the contact tolerance of 1 mm";
}

/// A palm that stands still, with a finger beside it: what lies on it is not carried, and lies in the hand.
TEST(Carried, WhatLiesOnAPartOfARobotThatStandsStill) {
  const auto model = world::Model::make(
      world::parse_scene("gravity: [0, 0, -9.81]\n"
                         "robots: [{name: r, mjcf: \"<mujoco><worldbody><body><geom type='box' size='.2 .2 .01' mass='1'/><body pos='1 0 "
                         "0'><joint name='x' type='slide' "
                         "axis='1 0 0' range='-2 2'/><geom type='sphere' size='.02' "
                         "mass='1'/></body></body></worldbody><actuator><position joint='x' kp='1000'/></actuator></mujoco>\"}]\n"
                         "objects: [{name: a, joint: free, mass: 0.2, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}]\n"
                         "fixed: [{name: ground, pose: {position: [0, 0, -1]}, shapes: [{half_space: {}}]}]\n",
                         "."));
  const Carried carried(*model);
  Workspace work(*model);
  world::KinematicsWorkspace kinematics_work(*model);
  world::Kinematics kinematics;
  for (const auto& [z, in_hand, aloft] : {std::tuple(0.06, true, false), {0.2, false, true}, {-0.95, false, false}}) {
    VectorXd q = model->neutral();
    q[2] = z;
    if (z < 0) q[0] = 0.5;
    world::calc_kinematics(*model, q, kinematics_work, kinematics);
    EXPECT_EQ(carried.lies_in_hand(kinematics, work), in_hand) << z;
    EXPECT_EQ(carried.any(kinematics, work), aloft) << z;
  }
}

TEST(Carried, NothingFallsWithoutGravity) {
  const auto model = make_model("[0, 0, 0]");
  EXPECT_FALSE(Carried(*model).possible());
  EXPECT_FALSE(any(*model, 0.3, 0.5));
}

TEST(Carried, WhatHangsOnAHingeDoesNotFall) {
  const auto model = world::Model::make(world::parse_scene(
      "gravity: [0, 0, -9.81]\n"
      "robots: [{name: r, mjcf: \"<mujoco><worldbody><body><joint name='x' type='slide' axis='1 0 0' range='-2 2'/><geom type='sphere' "
      "size='.02' mass='1'/></body></worldbody><actuator><position joint='x' kp='1000'/></actuator></mujoco>\"}]\n"
      "objects: [{name: flap, joint: hinge, axis: [0, 1, 0], pose: {position: [5, 0, 1]}, mass: 0.2, shapes: [{box: {size: [0.1, 0.1, "
      "0.1]}}]}]\n",
      "."));
  EXPECT_FALSE(Carried(*model).possible());
}

}  // namespace
}  // namespace stiction::contact::test
