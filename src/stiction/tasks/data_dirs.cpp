#include <cstdlib>
#include <sstream>
#include <system_error>

#include "stiction/core/find_upwards.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

namespace fs = std::filesystem;

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
  if (const char* path = std::getenv("ROS_PACKAGE_PATH")) {
    std::stringstream parts{std::string(path)};
    for (std::string part; std::getline(parts, part, ':');) {
      if (!part.empty()) dirs.emplace_back(part);
    }
  }
  if (const fs::path beside = core::find_upwards("cmeel.prefix/share", core::kInstalledLevels); !beside.empty()) dirs.push_back(beside);
  if (const std::string built_with = STICTION_PACKAGE_DIR; !built_with.empty()) dirs.emplace_back(built_with);
  return dirs;
}

}  // namespace stiction::tasks
