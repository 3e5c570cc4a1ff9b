#pragma once

#include <filesystem>
#include <span>

#include "stiction/world/robot_tree.hpp"
#include "stiction/world/xml_reader.hpp"

namespace stiction::world {

/// Adds what the <visual> elements of a URDF show to the tree. Nobody needs a picture in order to plan: an element that cannot be read is no
/// fault of the file, and goes to `unseen`.
/// @param folder  that paths are relative to  @param package_dirs  where package:// is looked up
/// Tests: tests/world/visuals_test.cpp
void read_urdf_visuals(const XmlReader& reader, const XMLElement& robot, const std::filesystem::path& folder,
                       std::span<const std::filesystem::path> package_dirs, RobotTree& tree);

}  // namespace stiction::world
