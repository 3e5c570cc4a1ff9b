#pragma once

#include "stiction/planning/planner.hpp"

namespace stiction::planning {

/// plan() from a start at which the robots are commanded elsewhere than where they are, as they were measured: their springs keep their strain, and a grip its
/// force. Overlaps are moved apart, and commands beyond the motors taken back, before the search begins (settle_start.hpp).
/// @param u_start  commands at the start (n_a) [rad or m]; empty: joints are commanded where they are
/// @returns as plan(); NumericalFailure: the start does not come to rest, `result.reason` says why
/// @throws  core::InvalidInput, as plan()
core::Status plan_from(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                       const core::RunControl& control, PlanResult& result);

}  // namespace stiction::planning
