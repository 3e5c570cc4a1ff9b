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

// Entries of the lists in a scene file. All of them @throws core::InvalidInput with file, line and field.

/// Key `name`.
std::string read_name(const YamlNode& node);
/// Key `convex_decomposition`, not together with the key of a hull.
std::optional<Decomposition> read_decomposition(const YamlNode& node, std::string_view hull_key);
/// Keys `torsional_friction` and `rolling_friction` [m], each may be left out. @param rule  of what holds the entry
SurfaceRule read_surface_rule(const YamlNode& node, SurfaceRule rule);
/// A centre of mass within rounding of the origin is there.
void round_center(ObjectSpec& object);
/// An entry of `objects`.
ObjectSpec read_object(const YamlNode& node);
/// The keys `file` of a scene, and `objects` where they are names of the file's bodies.
struct WholeScene {
  YamlNode file;
  std::optional<std::vector<std::string>> objects{};
};
/// Adds an entry of `robots`, or the `robot` of a whole scene, with what else its file brings, to the scene.
/// @param names  of bodies and geometries, grows  @param whole  nullptr for an entry of `robots`
void read_robot_into(const YamlNode& node, std::span<const std::filesystem::path> package_dirs, Scene& scene,
                     std::vector<std::string>& names, const WholeScene* whole = nullptr);

}  // namespace stiction::world
