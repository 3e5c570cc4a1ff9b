#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: what a step passes on its way that is beyond the distance in which it looked for contacts.

namespace stiction::dynamics::detail {

/// Adds the contacts of every pair that was out of reach at q and meets along q ⊕ s δq, 0 ≤ s ≤ 1, with δq of the last solution; true when there are
/// any. They have their rows from the next solution on. Nothing is looked at unless δq carries two bodies towards each other by more than
/// contact_distance + margin, and no pair is added twice.
/// @param margin  beyond scene.contact_distance, within which all contacts are known [m]
bool add_met(const world::Model& model, const StepInput& in, double margin, StepWorkspace::Impl& work);

}  // namespace stiction::dynamics::detail
