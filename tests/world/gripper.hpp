#pragma once

#include <fmt/format.h>

#include "world/robot_files.hpp"

namespace stiction::world::test {

/// A hand on sliders and two hinges with two fingers, each of a claw and of a pad that hangs on it without a joint, above a cube of 40 mm that lies on the ground.
/// Fingers have 400 N/m. Joints of the robot: x, y, z, pitch, yaw, left, right.
/// @param stroke   of each finger [m]; 19 mm take the pads to the cube
/// @param command  of each finger, at most [m]; 0: as far as its stroke
inline std::shared_ptr<const Model> make_gripper(const RobotFolder& folder, double mass, double stroke = 0.05, double command = 0) {
  const auto finger = [&](const char* name, int side) {
    return fmt::format(R"(<body name="{0}" pos="0 {1} -0.05"><joint name="{0}" type="slide" axis="0 {2} 0" range="0 {3}"/>
<geom type="box" size="0.01 0.005 0.04"/><body name="{0}_pad" pos="0 {4} -0.02"><geom type="box" size="0.01 0.003 0.02"/></body></body>)",
                       name, 0.05 * side, -side, stroke, -0.008 * side);
  };
  std::string actuators;
  for (const auto& [joint, stiffness] :
       {std::pair("x", 10000), {"y", 10000}, {"z", 10000}, {"pitch", 100}, {"yaw", 100}, {"left", 400}, {"right", 400}})
    actuators += fmt::format(R"(<position joint="{}" kp="{}"{}/>)", joint, stiffness,
                             command > 0 && stiffness == 400 ? fmt::format(R"( ctrllimited="true" ctrlrange="0 {}")", command) : "");
  folder.write("hand.xml", R"(<mujoco model="hand"><compiler angle="radian"/><worldbody><body name="hand" pos="0 0 0.3">
<joint name="x" type="slide" axis="1 0 0" range="-0.3 0.3"/><joint name="y" type="slide" axis="0 1 0" range="-0.3 0.3"/>
<joint name="z" type="slide" axis="0 0 1" range="-0.3 0.3"/><joint name="pitch" type="hinge" axis="0 1 0" range="-3 3"/>
<joint name="yaw" type="hinge" axis="0 0 1" range="-3 3"/><geom type="box" size="0.02 0.06 0.01"/>)" +
                               finger("left", 1) + finger("right", -1) + "</body></worldbody><actuator>" + actuators +
                               "</actuator></mujoco>");
  return Model::make(parse_scene(fmt::format(R"(
gravity: [0, 0, -10]
robots: [{{name: r, mjcf: hand.xml}}]
objects: [{{name: cube, joint: free, mass: {}, shapes: [{{box: {{size: [0.04, 0.04, 0.04]}}}}]}}]
fixed: [{{name: ground, shapes: [{{half_space: {{}}}}]}}]
)",
                                             mass),
                                 folder.path()));
}

/// The cube on the ground, and the open hand above it.
inline Eigen::VectorXd gripper_start(const Model& model) {
  Eigen::VectorXd q = model.neutral();
  q.head<3>() << 0, 0, 0.02;
  return q;
}

}  // namespace stiction::world::test
