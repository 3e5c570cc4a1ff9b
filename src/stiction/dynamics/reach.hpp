#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: which pairs an exact step may reach (S.22).

namespace stiction::dynamics::detail {

/// work.reach.near: distances within which the command may bring pairs together; `margin` is that of the query for all of them.
void guess_reach(const world::Model& model, const StepInput& in, const StepOptions& options, double margin, StepWorkspace::Impl& work);

/// (S.22): no row of a pair that work.reach.near left out is violated by the last solution.
bool stays_within_reach(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work);

}  // namespace stiction::dynamics::detail
