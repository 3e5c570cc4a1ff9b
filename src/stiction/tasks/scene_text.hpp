#pragma once

#include <string>

#include "stiction/world/model.hpp"

namespace stiction::tasks {

/// Writes the resolved scene as canonical text: equal scenes give equal texts, independent of file locations. The text holds every number
/// of the scene, the joints and geometries of the model (so the meshes of a robot, too) and the SHA-256 of every robot file. Numbers are
/// rounded to 12 digits, so that the last bits of a sine do not matter.
std::string make_scene_text(const world::Model& model);

}  // namespace stiction::tasks
