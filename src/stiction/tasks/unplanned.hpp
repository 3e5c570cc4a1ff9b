#pragma once

#include "stiction/planning/planner.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// Makes a plan result to display a task before planning: the start is the only knot, and the goal is set. status: MaxIterations, in 0 s.
/// Tests: tests/tasks/plan_slice_test.cpp
planning::PlanResult make_unplanned(const Task& task);

/// Simulates commands from the start of the task, with the dynamics and sub-steps of its planner, and returns a plan with one push.
/// @param commands  successive commands, one per column (n_a × N) [rad or m]
/// @param u_start   command before them (n_a); empty: the joint positions of the start
/// status: Solved: the motion ends at the goal; MaxIterations: it ends elsewhere; otherwise the status of the failed step that ends the
/// plan
/// @throws core::InvalidInput: sizes, numbers that are not finite
/// Tests: tests/tasks/commanded_test.cpp
planning::PlanResult make_commanded(const Task& task, const Eigen::MatrixXd& commands, const Eigen::VectorXd& u_start = {});

}  // namespace stiction::tasks
