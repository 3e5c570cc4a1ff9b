#pragma once

#include "stiction/planning/refine/half_steps.hpp"

namespace stiction::planning::refinement {

/// How the given plan does at half the sub-step.
struct GivenPlan {
  HalfSteps fine;
  bool reaches_goal = false;
};
GivenPlan look_at_given_plan(const Problem& problem, Scratch& scratch, Work& work);

/// The given plan is what comes out, with forces: one that was read from a file comes without.
void keep_given_plan(const Problem& problem, const GivenPlan& given, Scratch& scratch, RefineResult& out, Work& work);

}  // namespace stiction::planning::refinement
