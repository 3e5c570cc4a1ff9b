#pragma once

#include <vector>

#include "stiction/tasks/lint.hpp"

namespace stiction::tasks {

/// Links that are seen and cannot be touched ("visual"), and links much larger than the robot that they belong to ("size").
/// Tests: tests/tasks/lint_robots_test.cpp
void lint_robots(const Task& task, std::vector<Finding>& out);

}  // namespace stiction::tasks
