#pragma once

#include <vector>

#include "stiction/tasks/lint.hpp"

namespace stiction::tasks {

/// What the numbers of a task's text say: "units" and "quaternion".
void lint_numbers(const Task& task, std::vector<Finding>& out);

}  // namespace stiction::tasks
