#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace stiction::tasks {

/// The file of a scenario: anything that ends in .yaml or .yml or contains a '/', or the name of one in a folder scenarios/ beside a folder of tasks.
/// @param data_dirs  as in load_task()
/// @throws core::InvalidInput with the names that there are
std::filesystem::path find_scenario(const std::string& name_or_file, std::span<const std::filesystem::path> data_dirs);

}  // namespace stiction::tasks
