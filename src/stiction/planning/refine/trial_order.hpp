#pragma once

#include "stiction/planning/refine/attempt.hpp"

namespace stiction::planning::refinement {

/// The trials in the order in which they are wanted, up to the one that works.
/// Small steps are wanted most, and take most of the time. What comes to nothing at the steps of the plan seldom works at small ones, so that those come last,
/// and only where the plan was followed to its end, from which feedback leads to the goal, or where they take little.
/// @returns as planning::refine; `out` holds the plan and what became of it, not the counts of before and after
core::Status run_trials(const std::shared_ptr<const world::Model>& model, const Plan& plan, const PlannerOptions& options,
                        const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out);

}  // namespace stiction::planning::refinement
