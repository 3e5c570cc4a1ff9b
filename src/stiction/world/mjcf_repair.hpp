#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

namespace stiction::world {

/// Removes visual-only geoms with a missing mesh file and textures with a missing file, so that the rest compiles.
/// @param notes  receives one sentence per kind
void leave_out_missing_files(mjSpec* spec, std::vector<std::string>& notes);
/// Removes cube textures that are loaded from files, for an MJCF that does not compile with them. MuJoCo's message does not name such files.
/// @param notes  receives one sentence  @returns whether there is such a texture
bool leave_out_cube_textures(mjSpec* spec, std::vector<std::string>& notes);

/// Returns a note if ranges of hinges look like radians although no <compiler angle="…"> states the unit of their file; else an empty text.
/// @param model  the compiled spec
std::string find_unstated_degrees(mjSpec* spec, const mjModel& model);

}  // namespace stiction::world
