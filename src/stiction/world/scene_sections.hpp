#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/world/scene.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::world {

// Readers of the entries of the lists in a scene file. All of them @throws core::InvalidInput with file, line and field.

/// Reads the key `name`.
std::string read_name(const YamlNode& node);
/// Reads the key `convex_decomposition`, which excludes the key for a hull.
std::optional<Decomposition> read_decomposition(const YamlNode& node, std::string_view hull_key);
/// Reads the optional keys `torsional_friction` and `rolling_friction` [m]. @param rule  default: the rule of the enclosing entry
SurfaceRule read_surface_rule(const YamlNode& node, SurfaceRule rule);
/// Moves a centre of mass that differs from the origin only by rounding to the origin.
void round_center(ObjectSpec& object);
/// Reads an entry of `objects`.
ObjectSpec read_object(const YamlNode& node);
/// The key `file` of a scene, and the key `objects` if it lists names of the file's bodies.
struct WholeScene {
  YamlNode file;
  std::optional<std::vector<std::string>> objects{};
};
/// Adds an entry of `robots`, or the `robot` of a whole scene, and the other contents of its file to the scene.
/// @param names  names of bodies and geometries; receives new ones  @param whole  nullptr for an entry of `robots`
void read_robot_into(const YamlNode& node, std::span<const std::filesystem::path> package_dirs, Scene& scene,
                     std::vector<std::string>& names, const WholeScene* whole = nullptr);

}  // namespace stiction::world
