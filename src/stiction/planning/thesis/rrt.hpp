#pragma once

#include "stiction/planning/planner.hpp"

namespace stiction::planning::thesis {

/// Algorithms 2 and 3 as printed, on one thread: for Table 3.2, figures 3-4 and 3-6, and for readers of the code. The edges are single
/// large steps and jumps to contact samples, which need not be feasible for a robot. `plan` without options.thesis gives feasible plans.
/// @param options  with thesis; max_iterations is K
/// @returns out.status: Solved, MaxIterations, Cancelled, or NumericalFailure if the start does not come to rest; the tree in out.records
/// Tests: tests/planning/thesis_test.cpp
void grow_tree(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, PlanResult& out);

}  // namespace stiction::planning::thesis
