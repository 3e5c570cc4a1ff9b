#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace stiction::tasks {

/// Finds the file of a scenario: a path (it ends in .yaml or .yml or contains a '/'), or the name of a scenario in a folder scenarios/
/// beside a folder of tasks.
/// @param data_dirs  as in load_task()
/// @throws core::InvalidInput listing the known names
std::filesystem::path find_scenario(const std::string& name_or_file, std::span<const std::filesystem::path> data_dirs);

}  // namespace stiction::tasks
