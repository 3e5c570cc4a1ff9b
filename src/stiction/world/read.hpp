#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "stiction/world/scene.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::world {

/// Keys position [m], and quaternion_wxyz (unit to 1e-3, then normalised) or rpy (fixed axes [rad]); each may be left out.
Pose read_pose(const YamlNode& node);

/// An entry of a scene's `fixed`.
FixedSpec read_fixed(const YamlNode& node);

/// A map with the keys of a scene. Paths in it are relative to the file they are written in.
/// @param package_dirs  searched after the `package_dirs` of each robot
Scene read_scene(const YamlNode& node, std::span<const std::filesystem::path> package_dirs = {});

/// The whole of a file: a scene, or a task with one.
Scene read_scene_file(const YamlNode& top, std::span<const std::filesystem::path> package_dirs = {});

/// load_scene() of a text in memory (YAML or JSON). @param folder  that paths in it are relative to
/// @throws core::InvalidInput "field: got …, expected …"
Scene parse_scene(const std::string& text, const std::filesystem::path& folder, std::span<const std::filesystem::path> package_dirs = {});

/// '*' matches any run of characters.
bool matches_pattern(std::string_view pattern, std::string_view name);

}  // namespace stiction::world
