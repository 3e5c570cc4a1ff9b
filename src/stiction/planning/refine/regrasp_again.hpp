#pragma once

#include "stiction/planning/refine/problem.hpp"
#include "stiction/planning/regrasp.hpp"

namespace stiction::planning::refinement {

/// Plans a regrasp anew in small steps, from the present posture of the robot to the start of a push. The branches that move let go, keep a
/// clearance on their way, touch nothing before they arrive, and hold until the objects rest in the new grip.
/// @param clearance  [m]  @param number  of the push: it selects the random substream of the path search
/// @returns false: there is no path, or the objects neither stay nor are where the push needs them
bool regrasp_again(const Problem& problem, const Cursor& start, const Push& push, std::size_t number, double clearance, Scratch& scratch,
                   Work& work, Run& run);

/// Replays the commands of the plan's own regrasp, after the robot went back to where they start: a tail may have been cut.
bool regrasp_as_planned(const Problem& problem, const Cursor& start, const Push& push, Scratch& scratch, Work& work, Run& run);

}  // namespace stiction::planning::refinement
