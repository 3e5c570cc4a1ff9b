#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "stiction/world/model.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

// What the MJCF files of a scene say of where things are.

/// Puts the objects of MJCF files where the files have them, and the joints of robots that are in whole scenes.
/// @param placed  per object, becomes true where a file says it
void start_as_written(const world::Model& model, Eigen::VectorXd& q, std::vector<bool>& placed);

/// Puts joints and objects where a keyframe has them; what lies outside its limits goes to the nearest of them.
/// @throws core::InvalidInput: no file has a keyframe of this name
void start_at_keyframe(const world::YamlNode& name, const world::Model& model, Eigen::VectorXd& q, std::vector<bool>& placed);

/// Pose in the world of a site or a body that stands still. @throws core::InvalidInput: there is none of this name, or it moves
world::Pose find_place(const world::YamlNode& name, const world::Model& model);

}  // namespace stiction::tasks
