#pragma once

#include "stiction/planning/planner.hpp"

namespace stiction::planning {

/// @throws core::InvalidInput: sizes, tolerances, a goal inside a fixed body or outside the range of the object's joint
void validate(const PlanningProblem& problem);

}  // namespace stiction::planning
