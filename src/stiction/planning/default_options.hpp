#pragma once

#include "stiction/planning/planner.hpp"

namespace stiction::planning {

/// Options for moving an object: what has a unit follows from its length L and force F (world::Scales), κ from its weight, γ from its length,
/// sub-steps, clearances and what an object may move while it is let go from L, preload and brace from F.
/// Friction is Coulomb's, in a plane Anitescu's.
/// @param object  that of the goal, index in the model
PlannerOptions default_options(const world::Model& model, int object);

/// Where subgoals are drawn when no boxes are given. Of the goal's object and those that it hangs on: joint ranges, and where there are none the
/// places and angles between start and goal and a share of that way beyond them, at least L/2 and kBeyond. The other objects stay where they are.
std::vector<world::SampleBox> default_sample_boxes(const PlanningProblem& problem);

}  // namespace stiction::planning
