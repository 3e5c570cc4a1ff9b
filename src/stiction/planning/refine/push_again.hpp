#pragma once

#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// Simulates the commands of a push in small steps, and holds the last one until the objects rest. The regularisation holds objects back in
/// every sub-step (S.3), while nothing in the world does so for long.
/// @returns false: the push cannot be followed
bool push_again(const Problem& problem, const Cursor& start, const Push& push, Scratch& scratch, Work& work, Run& run);

}  // namespace stiction::planning::refinement
