#pragma once

#include <vector>

#include "stiction/tasks/lint.hpp"

namespace stiction::tasks {

/// Checks the numbers in a task's text: findings "units" and "quaternion".
void lint_numbers(const Task& task, std::vector<Finding>& out);

}  // namespace stiction::tasks
