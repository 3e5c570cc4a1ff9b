#pragma once

#include "stiction/planning/tree_search.hpp"

namespace stiction::planning {

/// The trees of a run, `trees` of them side by side, until a path is found or the budget is used up. One that stalls makes room for the next.
/// @param grown  told how they grow, where there is one
void grow_forest(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                 const core::RunControl& control, core::RunControl::Clock::time_point start, const GrowthSink& grown, PlanResult& out);

/// Grows one tree after the other for cheaper paths, until the deadline, the budget or a cancel.
void improve(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
             core::RunControl::Clock::time_point start, PlanResult& best);

}  // namespace stiction::planning
