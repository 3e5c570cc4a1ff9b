#pragma once

#include "stiction/planning/planner.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// What is shown of a task before it is planned: its start as the only knot of a plan, and its goal. status: MaxIterations.
/// Tests: tests/tasks/plan_slice_test.cpp
planning::PlanResult make_unplanned(const Task& task);

/// The motion that commands make from the start of the task, with the dynamics and the sub-steps of its planner, as a plan of one push.
/// @param commands  one after the other (n_a × N) [rad or m]
/// @param u_start   before them (n_a); empty: the joint positions of the start
/// status: Solved: it ends at the goal; MaxIterations: it ends elsewhere; else that of the step that has no solution, where the plan ends
/// @throws core::InvalidInput: sizes, numbers that are not finite
/// Tests: tests/tasks/commanded_test.cpp
planning::PlanResult make_commanded(const Task& task, const Eigen::MatrixXd& commands, const Eigen::VectorXd& u_start = {});

}  // namespace stiction::tasks
