#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "stiction/world/robot_tree.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {

/// Reads a URDF: revolute, continuous, prismatic and fixed joints; sphere, box, cylinder, capsule and (convex) mesh collisions; inertial
/// elements.
/// @param whole_scene  true: floating joints are read as well, for split_urdf
/// @throws core::InvalidInput "FILE:LINE: element: got …, expected …"
RobotContents read_urdf(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs,
                        const MeshOptions& mesh_options = {}, bool whole_scene = false);

/// The same for a text in memory, which messages call kTextName. @param folder  folder for its relative paths
RobotContents read_urdf_text(const std::string& text, const std::filesystem::path& folder,
                             std::span<const std::filesystem::path> package_dirs, const MeshOptions& mesh_options = {},
                             bool whole_scene = false);

/// True for a file whose root element is that of a URDF. The file is read only up to that element; if it has no element, its extension decides.
bool is_urdf(const std::filesystem::path& file);

/// Finds the file of a URI "package://PKG/REST", "model://PKG/REST", "file://PATH" or "file:PATH", or of a path. A relative path is relative to
/// `base_dir`. Characters may be percent-encoded, and '\\' may stand for '/'; a file with the name as written takes precedence. A package is
/// looked for in package_dirs and in the folders above base_dir: as a folder PKG in them, or as one of these folders if its name is PKG.
/// @returns an empty path if no file is found
std::filesystem::path find_resource(std::string_view uri, const std::filesystem::path& base_dir,
                                    std::span<const std::filesystem::path> package_dirs);

}  // namespace stiction::world
