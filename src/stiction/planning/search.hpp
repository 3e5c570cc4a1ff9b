#pragma once

#include "stiction/planning/planner.hpp"

namespace stiction::planning {

/// The loop of the planner: kTrees trees are grown in rounds until a path is found or the budget is used up; a tree that stalls makes room for a new one.
/// @param grown  told between rounds how the trees grow, where there is one
void search(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
            core::RunControl::Clock::time_point start, const GrowthSink& grown, PlanResult& out);

/// Grows one tree after the other for cheaper paths, until the deadline, the budget or a cancel.
/// @param found  told of each of them, where there is one
void improve(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
             core::RunControl::Clock::time_point start, const PlanSink& found, PlanResult& best);

}  // namespace stiction::planning
