#pragma once

#include "stiction/planning/planner.hpp"

namespace stiction::planning::thesis {

/// Algorithm 2 with Algorithm 3, as printed, on one thread: for Table 3.2, figures 3-4 and 3-6, and for readers. Its edges are single large steps and jumps
/// to contact samples, which nothing has to carry out; `plan` without options.thesis gives plans that can be.
/// @param options  with thesis; max_iterations is K
/// @returns in out: Solved, MaxIterations, Cancelled, or NumericalFailure where the start does not come to rest; the tree in `records`
/// Tests: tests/planning/thesis_test.cpp
void grow_tree(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, PlanResult& out);

}  // namespace stiction::planning::thesis
