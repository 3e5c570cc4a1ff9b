#pragma once

#include "stiction/planning/tree_search.hpp"

namespace stiction::planning {

/// What a tree reports, as part of a run that had so many extensions before it.
void place_in_run(const PlannerOptions& options, const core::RunControl& control, core::RunControl::Clock::time_point start, long before,
                  core::Progress& progress);

/// Adds counts to those of a run.
void add(const Counts& counts, PlanResult& out);

/// The trees of a run, `trees` of them side by side, until a path is found or the budget is used up. One that stalls makes room for the next.
/// @param grown  told how they grow, where there is one
void grow_forest(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                 const core::RunControl& control, core::RunControl::Clock::time_point start, const GrowthSink& grown, PlanResult& out);

}  // namespace stiction::planning
