#pragma once

#include "stiction/planning/planner.hpp"

namespace stiction::planning {

/// The loop of the planner: grows kTrees trees in rounds until a path is found or the budget is used up, and replaces trees that stall.
/// @param grown  receives the growth of the trees between rounds; may be empty
void search(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
            core::RunControl::Clock::time_point start, const GrowthSink& grown, PlanResult& out);

/// Grows one tree after the other to find cheaper paths, until the deadline, the end of the budget or a cancellation.
/// @param found  receives each cheaper plan; may be empty
void improve(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
             core::RunControl::Clock::time_point start, const PlanSink& found, PlanResult& best);

}  // namespace stiction::planning
