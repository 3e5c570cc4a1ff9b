#pragma once

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

/// Which links of a URDF are robots, which are objects and which stand still, by the rule of MjcfSplit: a tree is a topmost link with a joint and all below. A joint
/// that a <transmission> or <ros2_control> names has an actuator. Objects leave the robot and become objects of the contents, on hinges and sliders or, below
/// a floating joint, free; they form no pair with the link that they hang on.
/// @throws core::InvalidInput: links that are not there or that no joint moves
void split_urdf(const MjcfSplit& split, RobotContents& contents);

}  // namespace stiction::world
