#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <string>
#include <vector>

namespace stiction::world {

/// Leaves out geoms that are only seen and whose mesh file is missing, and textures whose file is missing, so that the rest compiles.
/// @param folder  of the file  @param notes  grows by a sentence on each kind
void leave_out_missing_files(mjSpec* spec, const std::filesystem::path& folder, std::vector<std::string>& notes);
/// Leaves out textures of cubes that are made of files, which MuJoCo does not name: for a file that does not compile with them.
/// @param notes  grows by a sentence  @returns whether there is any
bool leave_out_cube_textures(mjSpec* spec, std::vector<std::string>& notes);

/// A note where ranges of hinges look as if they were written in radians, and no <compiler angle="…"> of the file or of those that it
/// includes says which; else an empty text.
std::string find_unstated_degrees(const mjModel& model, const std::string& text, const std::filesystem::path& file);

}  // namespace stiction::world
