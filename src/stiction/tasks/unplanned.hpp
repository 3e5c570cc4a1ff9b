#pragma once

#include "stiction/planning/planner.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// What is shown of a task before it is planned: its start as the only knot of a plan, and its goal. status: MaxIterations.
/// Tests: tests/tasks/plan_slice_test.cpp
planning::PlanResult make_unplanned(const Task& task);

}  // namespace stiction::tasks
