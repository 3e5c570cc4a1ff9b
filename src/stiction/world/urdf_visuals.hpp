#pragma once

#include <filesystem>
#include <span>

#include "stiction/world/robot_tree.hpp"
#include "stiction/world/xml_reader.hpp"

namespace stiction::world {

/// Adds the <visual> elements of a URDF to the tree. Planning does not need visuals, so an element that cannot be read is no error; it is listed
/// in `unseen`.
/// @param folder  folder for relative paths  @param package_dirs  folders in which package:// is looked up
/// Tests: tests/world/visuals_test.cpp
void read_urdf_visuals(const XmlReader& reader, const XMLElement& robot, const std::filesystem::path& folder,
                       std::span<const std::filesystem::path> package_dirs, RobotTree& tree);

}  // namespace stiction::world
