#pragma once

#include "stiction/planning/forest.hpp"

namespace stiction::planning {

/// Grows one tree after the other for cheaper paths, until the deadline, the budget or a cancel.
void improve(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
             core::RunControl::Clock::time_point start, PlanResult& best);

}  // namespace stiction::planning
