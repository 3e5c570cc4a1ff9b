#include <cstdlib>
#include <sstream>
#include <system_error>

#include "stiction/core/find_upwards.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

namespace fs = std::filesystem;

namespace {

/// Folders listed in an environment variable, separated by ':'.
std::vector<fs::path> folders_in(const char* variable) {
  std::vector<fs::path> out;
  const char* value = std::getenv(variable);
  std::stringstream parts{std::string(value != nullptr ? value : "")};
  for (std::string part; std::getline(parts, part, ':');) {
    if (!part.empty()) out.emplace_back(part);
  }
  return out;
}

}  // namespace

std::vector<fs::path> default_data_dirs() {
  std::vector<fs::path> dirs;
  const auto add = [&dirs](const fs::path& dir) {
    std::error_code error;
    if (!dir.empty() && fs::is_directory(dir, error)) dirs.push_back(dir);
  };
  add(core::find_upwards("share/stiction/tasks", core::kInstalledLevels));
  add(STICTION_SOURCE_TASKS);
  return dirs;
}

std::vector<fs::path> default_package_dirs() {
  std::vector<fs::path> dirs;
  for (const fs::path& dir : folders_in("ROS_PACKAGE_PATH")) dirs.push_back(dir);
  for (const fs::path& prefix : folders_in("AMENT_PREFIX_PATH")) dirs.push_back(prefix / "share");  // ROS 2 installs PREFIX/share/PKG
  if (const fs::path beside = core::find_upwards("cmeel.prefix/share", core::kInstalledLevels); !beside.empty()) dirs.push_back(beside);
  if (const std::string built_with = STICTION_PACKAGE_DIR; !built_with.empty()) dirs.emplace_back(built_with);
  return dirs;
}

}  // namespace stiction::tasks
