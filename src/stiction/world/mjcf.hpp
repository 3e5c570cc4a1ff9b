#pragma once

#include <filesystem>
#include <string>

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

/// Reads an MJCF file. MuJoCo parses and compiles it (includes, defaults, classes, angles, meshes), and the compiled model is converted.
/// docs/theory/mjcf.md lists the conversion of each element.
/// @throws core::InvalidInput "FILE: mjcf: got …, expected …": errors of MuJoCo, or all unsupported elements in one message
/// @param robot  its split and fixed_base say which bodies are robots and objects
RobotContents read_mjcf(const std::filesystem::path& file, const RobotSpec& robot = {});

/// The same for a text in memory, which messages call kTextName. @param folder  folder for its relative paths
RobotContents read_mjcf_text(const std::string& text, const std::filesystem::path& folder, const RobotSpec& robot = {});

/// Appends the robot and the other contents of its file to a scene: objects, the fixed body "ROBOT_world", excluded pairs.
/// @param robot  with `mjcf` set; its stiffness may name some joints only
void add_mjcf(Scene& scene, const RobotSpec& robot);

}  // namespace stiction::world
