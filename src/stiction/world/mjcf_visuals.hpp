#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <map>

#include "stiction/world/mjcf_roles.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

/// Adds the visible geoms of a compiled MJCF to the tree: geoms of the groups 0 to 2, which MuJoCo's viewer shows, except transparent geoms and
/// markers of mocap bodies. A colliding geom without material is left out if visual-only geoms of its body cover it.
/// @param X_OB  per body that an object's joint moves: the pose of its frame in the object's frame
/// Tests: tests/world/visuals_test.cpp
void list_mjcf_visuals(const mjModel& m, const MjcfRoles& roles, const std::filesystem::path& file, const std::map<int, Pose>& X_OB,
                       RobotTree& tree);

}  // namespace stiction::world
