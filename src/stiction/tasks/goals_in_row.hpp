#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

// A sequence of goals that a run reaches one after another, instead of the goal of a task. Each goal is read as if the objects were at the
// previous goal, and bystanders at their positions of that moment. Tolerances stay.

/// Reads a list of goals from a file. Each goal is a list of numbers as in set_goal(), with ~ for any value, or a mapping as in the section
/// `goal` of a task.
/// @throws core::InvalidInput "goal 3 of 7 in FILE:LINE: got …, expected …", also for an impossible goal
/// Tests: tests/tasks/goals_in_row_test.cpp
std::vector<planning::PlanningProblem> load_goals(const Task& task, const std::filesystem::path& file);

/// Reads the goals from a text in memory. @param name  name of the list in messages: "NAME[2]: got …, expected …"
std::vector<planning::PlanningProblem> parse_goals(const Task& task, const std::string& text, const std::string& name);

/// Makes the goals from numbers as in set_goal(). @param name  name in messages: "NAME 3 of 7: got …, expected …"; a single goal gives the
/// messages of set_goal()
std::vector<planning::PlanningProblem> make_goals(const Task& task, const std::vector<std::vector<std::optional<double>>>& goals,
                                                  const std::string& name);

}  // namespace stiction::tasks
