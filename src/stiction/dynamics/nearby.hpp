#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: kinematics and contacts at the q from which a step starts. The samples of a local model start from one q and find them once.

namespace stiction::dynamics::detail {

/// Kinematics at q, unless the workspace has them from the last step.
void calc_kinematics(const world::Model& model, VectorRef q, StepWorkspace::Impl& work);

/// The contacts of all pairs nearer than scene.contact_distance + margin and their Jacobians, unless the workspace has them from the last step.
/// @param margin        [m]
/// @param fall          how far an object may fall [m]: of a patch, the points up to there are listed as well, since the object may tip onto them
/// @param within_reach  only pairs nearer than work.reach.near
void find_contacts(const world::Model& model, const StepInput& in, double margin, double fall, bool within_reach,
                   StepWorkspace::Impl& work);

}  // namespace stiction::dynamics::detail
