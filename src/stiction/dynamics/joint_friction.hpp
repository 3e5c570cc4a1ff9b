#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: dry friction of hinges and sliders (S.19), a spring about δq = 0 that gives way at τ_f.
// docs/theory/joint_friction.md.

namespace stiction::dynamics::detail {

/// Finds the hinges and sliders with dry friction. All of them start sticking.
std::vector<FrictionJoint> find_friction_joints(const world::Model& model);

/// Sets the stiffness k of sticking joints for this step: τ_f divided by the creep allowed per step, or, in smoothed steps, at most the
/// stiffness that follows from the barrier weight κ.
void set_stiction(const world::Model& model, const StepOptions& options, StepWorkspace::Impl& work);

/// Writes the joints' part of Q and b: hk for a sticking joint, the force ±τ_f for a sliding joint.
void set_friction(const StepOptions& options, StepWorkspace::Impl& work);

/// Adds the rows −side·δq − τ_f/k + z/(hk) ≥ 0 of sliding joints.
void add_friction(const StepOptions& options, StepWorkspace::Impl& work);

/// Lets a joint slide in the next round if its spring holds more than τ_f at the solution. Same scheme as saturate_motors().
/// @returns true if any joint changed
bool slide_joints(StepWorkspace::Impl& work);

/// Reads the friction forces of the joints on their coordinates.
void read_friction(const world::Model& model, const StepOptions& options, const StepWorkspace::Impl& work, StepResult& out);

}  // namespace stiction::dynamics::detail
