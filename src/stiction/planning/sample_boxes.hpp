#pragma once

#include "stiction/planning/planner.hpp"

namespace stiction::planning {

/// Where subgoals are drawn when no boxes are given. Of the goal's object and those that it hangs on: joint ranges, and where there are none the
/// places and angles between start and goal and a share of that way beyond them, at least L/2 and kBeyond. The other objects stay where they are.
std::vector<world::SampleBox> default_sample_boxes(const PlanningProblem& problem);

}  // namespace stiction::planning
