#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "stiction/execution/contact_control/control_scenario.hpp"

namespace stiction::tasks {

/// What a YAML file says of a robot whose reference goes through things that it does not know (keys: scenarios/README.md).
/// @param package_dirs  where package:// of a robot is looked up after its own
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …": unknown keys, times that do not increase, λ_max ≤ 0, a reference outside joint limits, …
execution::ControlScenario load_control_scenario(const std::filesystem::path& file,
                                                 std::span<const std::filesystem::path> package_dirs = {});

/// A scenario in memory. @param text  as in a file (YAML or JSON)  @param folder  that paths in it are relative to
/// @throws core::InvalidInput "field: got …, expected …"
execution::ControlScenario parse_control_scenario(const std::string& text, const std::filesystem::path& folder,
                                                  std::span<const std::filesystem::path> package_dirs = {});

}  // namespace stiction::tasks
