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

/// Name of the fixed body that has the shapes of a robot's file which no joint moves and no link has.
inline std::string name_of_fixed(const RobotSpec& robot) { return robot.name + "_world"; }

/// Appends the robot and the other contents of its file to a scene: objects, the fixed body "ROBOT_world", excluded pairs.
/// @param robot  with `mjcf` set; its stiffness may name some joints only
void add_mjcf(Scene& scene, const RobotSpec& robot);

/// Excludes contact between two bodies of the file of a robot, by filters of the scene. Bodies that are welded to them may still touch.
/// @param a, b  names in the file: links of the robot, or bodies that belong to objects or to the world
void keep_apart(Scene& scene, const RobotSpec& robot, const RobotContents& contents, const std::string& a, const std::string& b);

}  // namespace stiction::world
