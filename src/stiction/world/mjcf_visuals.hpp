#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <map>

#include "stiction/world/mjcf_roles.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

/// Adds what a compiled MJCF shows to the tree: geoms of the groups 0 to 2, which MuJoCo's viewer shows, unless they are transparent or mark a
/// mocap body. A geom that collides and has no material is not shown where geoms of its body that are only seen take its place.
/// @param X_OB  per body that an object's joint moves: its frame in the object's
/// Tests: tests/world/visuals_test.cpp
void list_mjcf_visuals(const mjModel& m, const MjcfRoles& roles, const std::filesystem::path& file, const std::map<int, Pose>& X_OB,
                       RobotTree& tree);

}  // namespace stiction::world
