#pragma once

#include <span>

#include "stiction/dynamics/program.hpp"

// Internal to the layer: kinematics and contacts at the q from which a step starts. The samples of a local model start from one q and find them once.

namespace stiction::dynamics::detail {

/// Kinematics at q, unless the workspace has them from the last step.
void calc_kinematics(const world::Model& model, VectorRef q, StepWorkspace::Impl& work);

/// Contacts nearer than scene.contact_distance + margin and their Jacobians, unless the workspace has them from the last step.
/// @param near  per pair: the distance from which on it is left out [m]; or nothing
void find_contacts(const world::Model& model, const StepInput& in, double margin, std::span<const double> near, StepWorkspace::Impl& work);

}  // namespace stiction::dynamics::detail
