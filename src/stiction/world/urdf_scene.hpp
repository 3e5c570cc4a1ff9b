#pragma once

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

/// Splits the links of a URDF into robots, objects and fixed links by the rule of MjcfSplit. A tree is a topmost link with a joint and all links
/// below it. A joint has an actuator if a <transmission> or <ros2_control> names it. Objects are moved from the robot to the objects of the
/// contents; they have hinges and sliders, or are free below a floating joint. They form no pair with the link that they hang on.
/// @throws core::InvalidInput: a named link does not exist, or no joint moves it
void split_urdf(const MjcfSplit& split, RobotContents& contents);

}  // namespace stiction::world
