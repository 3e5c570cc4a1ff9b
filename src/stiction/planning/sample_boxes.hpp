#pragma once

#include "stiction/planning/planner.hpp"

namespace stiction::planning {

/// Default boxes from which subgoals are drawn, for the goal's objects and their carriers. A box is the range of the joint. Without limits,
/// it is the way from start to goal and a share of that way beyond, at least L/2 and kBeyond. The other objects stay where they are.
std::vector<world::SampleBox> default_sample_boxes(const PlanningProblem& problem);

}  // namespace stiction::planning
