#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "stiction/world/model.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

// Positions of objects, joints and sites from the MJCF files of a scene.

/// Sets objects of MJCF files, and joints of robots from whole-scene files, to their positions in the files.
/// @param placed  per object: set to true if a file gives its position
void start_as_written(const world::Model& model, Eigen::VectorXd& q, std::vector<bool>& placed);

/// Sets joints and objects to a keyframe. Coordinates outside their limits are clamped to the nearest limit.
/// @param notes  gets a sentence if the keyframe moves bodies that stand still in the model; may be null
/// @throws core::InvalidInput: no file has a keyframe with this name
void start_at_keyframe(const world::YamlNode& name, const world::Model& model, Eigen::VectorXd& q, std::vector<bool>& placed,
                       std::vector<std::string>* notes);

/// Pose of an object's body, as its file has it, in the frame of the object. The frame of a planar object is at its hinge.
world::Pose find_body_of_object(const world::Model& model, int object);

/// World pose of a fixed site or body. @throws core::InvalidInput: no site or body with this name, or it moves
world::Pose find_place(const world::YamlNode& name, const world::Model& model);

}  // namespace stiction::tasks
