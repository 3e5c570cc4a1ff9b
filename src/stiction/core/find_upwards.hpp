#pragma once

#include <filesystem>

namespace stiction::core {

/// Finds a file or folder that was installed together with this code. The search begins in the folder of the program or shared library that
/// contains the code, then goes through the parents of that folder.
/// @param name    relative path, such as share/stiction/tasks
/// @param levels  number of parent folders to search
/// @returns an absolute path; empty if nothing of that name is found
std::filesystem::path find_upwards(const std::filesystem::path& name, int levels);

/// Number of parent folders from the Python module in share/stiction/python/stiction up to the installation prefix. This is the longest such
/// way in an installation.
inline constexpr int kInstalledLevels = 4;

}  // namespace stiction::core
