#pragma once

#include <filesystem>
#include <string>
#include <variant>

#include "stiction/tasks/scenarios.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::python {

/// The name of a built-in scenario, or a file: what is no str is a file.
using ScenarioFile = std::variant<std::string, std::filesystem::path>;

inline std::filesystem::path file_of(const ScenarioFile& scenario) {
  if (const auto* file = std::get_if<std::filesystem::path>(&scenario)) return *file;
  return tasks::find_scenario(std::get<std::string>(scenario), tasks::default_data_dirs());
}

}  // namespace stiction::python
