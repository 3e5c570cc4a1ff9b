#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: kinematics and contacts at the start q of a step. Samples of a local model with the same q compute them once.

namespace stiction::dynamics::detail {

/// Computes the kinematics at q, unless the workspace has them from the last step.
void calc_kinematics(const world::Model& model, VectorRef q, StepWorkspace::Impl& work);

/// Computes the contacts of all pairs nearer than scene.contact_distance + margin, and their Jacobians, unless the workspace has them from
/// the last step.
/// @param margin        [m]
/// @param fall          how far an object may fall [m]; patch points up to this distance are listed too, because the object may tip onto
///                      them
/// @param within_reach  only pairs nearer than work.reach.near
void find_contacts(const world::Model& model, const StepInput& in, double margin, double fall, bool within_reach,
                   StepWorkspace::Impl& work);

}  // namespace stiction::dynamics::detail
