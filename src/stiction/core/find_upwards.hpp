#pragma once

#include <filesystem>

namespace stiction::core {

/// A file or folder that was installed together with this code: looked up in the folder of the program or shared library that holds the
/// code, then in its parents.
/// @param name    relative path, such as share/stiction/tasks
/// @param levels  how many parents are looked into
/// @returns an absolute path; empty where nothing of that name is found
std::filesystem::path find_upwards(const std::filesystem::path& name, int levels);

/// Parents between the Python module in share/stiction/python/stiction and the prefix of its installation, the longest way in one.
inline constexpr int kInstalledLevels = 4;

}  // namespace stiction::core
