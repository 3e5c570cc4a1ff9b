#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: contacts that a long step meets beyond the distance within which it looked for contacts.

namespace stiction::dynamics::detail {

/// Adds the contacts of every pair that was out of reach at q and meets along q ⊕ s δq, 0 ≤ s ≤ 1, with δq of the last solution. Their rows
/// enter the program of the next solve. The function only searches if δq moves two bodies towards each other by more than contact_distance
/// + margin, and it adds no pair twice.
/// @param margin  margin on scene.contact_distance within which all contacts are known [m]
/// @returns true if a contact was added
bool add_met(const world::Model& model, const StepInput& in, double margin, StepWorkspace::Impl& work);

}  // namespace stiction::dynamics::detail
