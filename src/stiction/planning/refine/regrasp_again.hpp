#pragma once

#include "stiction/planning/refine/problem.hpp"
#include "stiction/planning/regrasp.hpp"

namespace stiction::planning::refinement {

/// From where the robot is to where a push starts, planned anew in small steps: the branches that go elsewhere let go, keep a clearance on their way, touch
/// nothing before they arrive, and hold until the objects rest in the new grip; at full friction and at less.
/// @param clearance  [m]  @param number  of the push: the search for a path has its own stream of random numbers
/// @returns false: there is no path, or the objects neither stay nor are where the push wants them
bool regrasp_again(const Problem& problem, const Cursor& start, const Push& push, std::size_t number, double clearance, Scratch& scratch,
                   Work& work, Run& run);

/// The commands of the plan's own regrasp, after a way back to where they start: a tail may have been cut.
bool regrasp_as_planned(const Problem& problem, const Cursor& start, const Push& push, Scratch& scratch, Work& work, Run& run);

}  // namespace stiction::planning::refinement
