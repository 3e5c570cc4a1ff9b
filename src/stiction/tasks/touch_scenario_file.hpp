#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "stiction/execution/touch/touch_scenario.hpp"

namespace stiction::tasks {

/// What a YAML file says of an arm that goes to a posture among things that it does not know (keys: scenarios/README.md).
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …": unknown keys, a goal outside joint limits, a name that is taken, …
execution::TouchScenario load_touch_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs = {});

/// A scenario in memory. @param text  as in a file (YAML or JSON)  @param folder  that paths in it are relative to
/// @throws core::InvalidInput "field: got …, expected …"
execution::TouchScenario parse_touch_scenario(const std::string& text, const std::filesystem::path& folder,
                                              std::span<const std::filesystem::path> package_dirs = {});

}  // namespace stiction::tasks
