#pragma once

#include "stiction/planning/refine/best_run.hpp"

namespace stiction::planning::refinement {

/// What the branches of the robot do on their way to a push.
struct Moves {
  world::ChainMask moving = 0;   ///< branches that go to another posture
  world::ChainMask relaxed = 0;  ///< branches that stay and only change how they push
};
Moves moves_to(const Problem& problem, const Cursor& at, const Push& push);

/// From where the robot is to where a push starts: it lets go, keeps run.clearance on its way, touches nothing before it arrives, and holds until the objects
/// rest in the new grip; at full friction and at options.regrasp_friction of it.
/// @param number  of the push: the search has its own stream of random numbers
/// @returns false: there is no path, or the objects neither stay nor are where the push wants them
bool regrasp_anew(CommandFollower& follower, const Push& push, std::size_t number, const Moves& moves, Run& run);

/// The commands of the plan's own regrasp, after a way back to where they start: a tail may have been cut.
bool regrasp_as_planned(CommandFollower& follower, const Push& push, Run& run);

}  // namespace stiction::planning::refinement
