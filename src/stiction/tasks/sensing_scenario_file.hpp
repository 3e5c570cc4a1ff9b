#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "stiction/sensing/scenario.hpp"

namespace stiction::tasks {

/// Reads a sensing scenario from a YAML file: a robot, its joint torques and measurements (schema: tasks/schema/sensing.schema.json).
/// @param package_dirs  folders for package:// paths, searched after those of each robot
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …"
sensing::Scenario load_sensing_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs);

/// Reads a scenario from memory. @param text  content of a file (YAML or JSON)  @param folder  base folder of its relative paths
/// @throws core::InvalidInput "field: got …, expected …"
sensing::Scenario parse_sensing_scenario(const std::string& text, const std::filesystem::path& folder,
                                         std::span<const std::filesystem::path> package_dirs);

}  // namespace stiction::tasks
