#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

// Goals that a run reaches one after another, in place of the goal of a task. Each is read as if the objects were where the goal before left them, and bystanders
// stand where they then are; tolerances stay.

/// Goals of a file: a list. Each is numbers as of set_goal(), ~ for any value, or a mapping as of the section `goal` of a task.
/// @throws core::InvalidInput "goal 3 of 7 in FILE:LINE: got …, expected …", also of a goal that cannot be
/// Tests: tests/tasks/goals_in_row_test.cpp
std::vector<planning::PlanningProblem> load_goals(const Task& task, const std::filesystem::path& file);

/// The same of a text in memory. @param name  of the list, for messages: "NAME[2]: got …, expected …"
std::vector<planning::PlanningProblem> parse_goals(const Task& task, const std::string& text, const std::string& name);

/// Goals in numbers, as of set_goal(). @param name  for messages: "NAME 3 of 7: got …, expected …"; of one goal alone those of set_goal()
std::vector<planning::PlanningProblem> make_goals(const Task& task, const std::vector<std::vector<std::optional<double>>>& goals,
                                                  const std::string& name);

}  // namespace stiction::tasks
