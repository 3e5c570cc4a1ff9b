#pragma once

#include <vector>

#include "stiction/tasks/lint.hpp"

namespace stiction::tasks {

/// Finds links with visual but no collision geometry ("visual"), and links much larger than the reach of their robot ("size").
/// Tests: tests/tasks/lint_robots_test.cpp
void lint_robots(const Task& task, std::vector<Finding>& out);

}  // namespace stiction::tasks
