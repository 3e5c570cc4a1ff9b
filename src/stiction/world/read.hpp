#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "stiction/world/scene.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::world {

/// Reads a pose from the keys position [m], and quaternion_wxyz (unit to 1e-3, then normalised) or rpy (fixed axes [rad]). All are optional.
Pose read_pose(const YamlNode& node);

/// Reads an entry of a scene's `fixed`.
FixedSpec read_fixed(const YamlNode& node);

/// Reads a map with the keys of a scene. Its paths are relative to the file that contains them.
/// @param package_dirs  folders searched after the `package_dirs` of each robot
Scene read_scene(const YamlNode& node, std::span<const std::filesystem::path> package_dirs = {});

/// Reads the scene of a whole file, which is a scene or a task with a scene.
Scene read_scene_file(const YamlNode& top, std::span<const std::filesystem::path> package_dirs = {});

/// The same as load_scene(), for a text in memory (YAML or JSON). @param folder  folder for its relative paths
/// @throws core::InvalidInput "field: got …, expected …"
Scene parse_scene(const std::string& text, const std::filesystem::path& folder, std::span<const std::filesystem::path> package_dirs = {});

/// True if a name matches a pattern, in which '*' matches any run of characters.
bool matches_pattern(std::string_view pattern, std::string_view name);

}  // namespace stiction::world
