#pragma once

#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// The commands of a push in small steps. The last one is held until the objects rest: the regularisation holds them back in every sub-step (S.3), in the world
/// nothing does for long.
/// @returns false: it comes to nothing
bool push_again(const Problem& problem, const Cursor& start, const Push& push, Scratch& scratch, Work& work, Run& run);

}  // namespace stiction::planning::refinement
