#include "stiction/tasks/scenarios.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

namespace fs = std::filesystem;

fs::path find_scenario(const std::string& name_or_file, std::span<const fs::path> data_dirs) {
  if (name_or_file.ends_with(".yaml") || name_or_file.ends_with(".yml") || name_or_file.find('/') != std::string::npos) return name_or_file;
  std::vector<fs::path> folders;
  for (const fs::path& dir : data_dirs) folders.push_back(dir.parent_path() / "scenarios");
  for (const fs::path& folder : folders) {
    const fs::path file = folder / (name_or_file + ".yaml");
    std::error_code error;
    if (!name_or_file.empty() && fs::is_regular_file(file, error)) return file;
  }
  const std::vector<std::string> tasks = list_tasks(data_dirs);
  const bool is_task = std::ranges::find(tasks, name_or_file) != tasks.end();
  core::throw_invalid("scenario", fmt::format("'{}'{}", name_or_file, is_task ? ", which is a task" : ""),
                      fmt::format("a file ending in .yaml or one of {}", world::list_with_hint(name_or_file, list_tasks(folders))));
}

}  // namespace stiction::tasks
