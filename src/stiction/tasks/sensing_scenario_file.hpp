#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "stiction/sensing/scenario.hpp"

namespace stiction::tasks {

/// What a YAML file says of a robot, its torques and what was measured (schema: tasks/schema/sensing.schema.json).
/// @param package_dirs  searched after those of each robot
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …"
sensing::Scenario load_sensing_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs);

/// A scenario in memory. @param text  as in a file (YAML or JSON)  @param folder  that paths in it are relative to
/// @throws core::InvalidInput "field: got …, expected …"
sensing::Scenario parse_sensing_scenario(const std::string& text, const std::filesystem::path& folder,
                                         std::span<const std::filesystem::path> package_dirs);

}  // namespace stiction::tasks
