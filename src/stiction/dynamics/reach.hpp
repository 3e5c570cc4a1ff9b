#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: which pairs an exact step may reach (S.22).

namespace stiction::dynamics::detail {

/// Sets work.reach.near, the distances within which the command may bring pairs together. `margin` is the margin of the query for all
/// pairs.
void guess_reach(const world::Model& model, const StepInput& in, const StepOptions& options, double margin, StepWorkspace::Impl& work);

/// True if the last solution violates no row of a pair that work.reach.near left out (S.22), by the test (S.23).
bool stays_within_reach(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work);

}  // namespace stiction::dynamics::detail
