#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "stiction/world/robot_tree.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {

/// Reads revolute, continuous, prismatic and fixed joints; sphere, box, cylinder, capsule and (convex) mesh collisions; inertial elements.
/// @param whole_scene  floating joints are read as well, for split_urdf
/// @throws core::InvalidInput "FILE:LINE: element: got …, expected …"
RobotContents read_urdf(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs,
                        const MeshOptions& mesh_options = {}, bool whole_scene = false);

/// The same of a text in memory, which messages name kTextName. @param folder  that paths in it are relative to
RobotContents read_urdf_text(const std::string& text, const std::filesystem::path& folder,
                             std::span<const std::filesystem::path> package_dirs, const MeshOptions& mesh_options = {},
                             bool whole_scene = false);

/// A file whose root element is that of a URDF; one without an element is judged by its ending. It is read no further than that element.
bool is_urdf(const std::filesystem::path& file);

/// The file of "package://PKG/REST" or "model://PKG/REST", "file://PATH", "file:PATH" or a path, relative to `base_dir` where it is not absolute.
/// Characters may be percent-encoded, and '\\' may stand for '/'; a file whose name is as written goes first. A package is looked for in
/// package_dirs and in the folders above base_dir, as a folder PKG or as a folder that is itself called PKG. Empty when nothing is there.
std::filesystem::path find_resource(std::string_view uri, const std::filesystem::path& base_dir,
                                    std::span<const std::filesystem::path> package_dirs);

}  // namespace stiction::world
