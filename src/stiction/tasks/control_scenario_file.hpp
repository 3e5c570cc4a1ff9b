#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "stiction/execution/contact_control/control_scenario.hpp"

namespace stiction::tasks {

/// Reads a control scenario from a YAML file: a robot whose reference passes through unknown obstacles (keys: scenarios/README.md).
/// @param package_dirs  folders for package:// paths, searched after the robot's own folders
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …": unknown keys, times that do not increase, λ_max ≤ 0, a reference
///         outside joint limits, …
execution::ControlScenario load_control_scenario(const std::filesystem::path& file,
                                                 std::span<const std::filesystem::path> package_dirs = {});

/// Reads a scenario from memory. @param text  content of a file (YAML or JSON)  @param folder  base folder of its relative paths
/// @throws core::InvalidInput "field: got …, expected …"
execution::ControlScenario parse_control_scenario(const std::string& text, const std::filesystem::path& folder,
                                                  std::span<const std::filesystem::path> package_dirs = {});

}  // namespace stiction::tasks
