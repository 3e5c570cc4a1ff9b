#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

/// An MJCF file as the project sees it.
struct MjcfModel {
  RobotTree robot;                  ///< everything on hinges and slides and what is welded to the world; root link "world"
  std::vector<ObjectSpec> objects;  ///< bodies with a free joint
  std::vector<GeometrySpec> fixed;  ///< geometry of the world body, and all planes, in its frame
  std::vector<std::pair<std::string, std::string>> excludes;  ///< names of bodies
};

/// MuJoCo parses and compiles the file (includes, defaults, classes, angles, meshes), and the compiled model is read.
/// docs/theory/mjcf.md says what becomes what.
/// @throws core::InvalidInput "FILE: mjcf: got …, expected …": what MuJoCo refuses, and all elements that are not supported in one message
MjcfModel read_mjcf(const std::filesystem::path& file);

/// The same of a text in memory, which messages name kTextName. @param folder  that paths in it are relative to
MjcfModel read_mjcf_text(const std::string& text, const std::filesystem::path& folder);

/// Of a robot whose `mjcf` is set: its text, or its file.
MjcfModel read_mjcf_of(const RobotSpec& robot);

/// Appends the robot and all that comes with its file to a scene: objects, the fixed body "ROBOT_world", excluded pairs.
/// @param robot  with `mjcf` set; its stiffness may name some joints only
void add_mjcf(Scene& scene, const RobotSpec& robot);

}  // namespace stiction::world
