#pragma once

#include <string>

#include "stiction/world/model.hpp"

namespace stiction::tasks {

/// The resolved scene as text in a canonical form: equal scenes give equal texts wherever their files lie. Holds every number of
/// the scene, the joints and geometries of the model (so the meshes of a robot, too) and the SHA-256 of every robot file. Numbers are
/// rounded to 12 digits, so that the last bits of a sine do not matter.
std::string make_scene_text(const world::Model& model);

}  // namespace stiction::tasks
