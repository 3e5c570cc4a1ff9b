#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "stiction/execution/touch/touch_scenario.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// Reads a touch scenario from a YAML file: an arm that moves to a posture among unknown obstacles (keys: scenarios/README.md).
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …": unknown keys, a goal outside joint limits, a name that is taken, …
execution::TouchScenario load_touch_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs = {});

/// Reads a scenario from memory. @param text  content of a file (YAML or JSON)  @param folder  base folder of its relative paths
/// @throws core::InvalidInput "field: got …, expected …"
execution::TouchScenario parse_touch_scenario(const std::string& text, const std::filesystem::path& folder,
                                              std::span<const std::filesystem::path> package_dirs = {});

/// Reads a scenario that precedes a run of a task (touch_first.hpp). It uses the scene and start of this task, whichever task the file
/// names. The file may have no moves; the run then uses the uncorrected, wrong positions.
/// @throws core::InvalidInput: as above; a file with its own scene
execution::TouchScenario load_touch_scenario(const std::filesystem::path& file, const Task& task);

}  // namespace stiction::tasks
