#pragma once

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

/// Mounts the robots of other files on links of this robot, in the order of `robot.mounts`; a link may belong to a robot mounted earlier. URDF
/// and MJCF may be mixed. Links and joints of a mounted file keep their names, after the mount's name as a prefix if it has one. The root link
/// of an MJCF, "world" in the file, gets the name of the mount or else of the file.
/// @throws core::InvalidInput "mount[I].on: …": the link does not exist, the file contains objects, or a name is already in use
/// Tests: tests/world/mount_test.cpp
void mount_all(const RobotSpec& robot, RobotContents& contents);

}  // namespace stiction::world
