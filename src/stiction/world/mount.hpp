#pragma once

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

/// Hangs the robots of other files on links of this one, as `robot.mounts` says, one after the other: each may hang on what came before. URDF
/// and MJCF mix. Links and joints of a mounted file keep their names, with the mount's name in front where it has one; the root link of an
/// MJCF, "world" there, is called by that name or by the file's.
/// @throws core::InvalidInput "mount[I].on: …": a link that is not there, a file that brings objects, a name that is there already
/// Tests: tests/world/mount_test.cpp
void mount_all(const RobotSpec& robot, RobotContents& contents);

}  // namespace stiction::world
