#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "stiction/execution/touch/touch_scenario.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// What a YAML file says of an arm that goes to a posture among things that it does not know (keys: scenarios/README.md).
/// @throws core::InvalidInput "FILE:LINE: field: got …, expected …": unknown keys, a goal outside joint limits, a name that is taken, …
execution::TouchScenario load_touch_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs = {});

/// A scenario in memory. @param text  as in a file (YAML or JSON)  @param folder  that paths in it are relative to
/// @throws core::InvalidInput "field: got …, expected …"
execution::TouchScenario parse_touch_scenario(const std::string& text, const std::filesystem::path& folder,
                                              std::span<const std::filesystem::path> package_dirs = {});

/// A scenario that a run of a task begins with (touch_first.hpp): in its scene and from its start, whichever task the file names. The
/// moves may be left out: the run then goes by what is not right.
/// @throws core::InvalidInput: as above, a file with a scene of its own
execution::TouchScenario load_touch_scenario(const std::filesystem::path& file, const Task& task);

}  // namespace stiction::tasks
