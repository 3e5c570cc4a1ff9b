#pragma once

#include <filesystem>
#include <string>

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

/// MuJoCo parses and compiles the file (includes, defaults, classes, angles, meshes), and the compiled model is read.
/// docs/theory/mjcf.md says what becomes what.
/// @throws core::InvalidInput "FILE: mjcf: got …, expected …": what MuJoCo refuses, and all elements that are not supported in one message
/// @param robot  its split and fixed_base say which bodies are robots and objects
RobotContents read_mjcf(const std::filesystem::path& file, const RobotSpec& robot = {});

/// The same of a text in memory, which messages name kTextName. @param folder  that paths in it are relative to
RobotContents read_mjcf_text(const std::string& text, const std::filesystem::path& folder, const RobotSpec& robot = {});

/// Appends the robot and all that comes with its file to a scene: objects, the fixed body "ROBOT_world", excluded pairs.
/// @param robot  with `mjcf` set; its stiffness may name some joints only
void add_mjcf(Scene& scene, const RobotSpec& robot);

}  // namespace stiction::world
