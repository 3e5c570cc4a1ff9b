#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: dry friction of hinges and sliders (S.19), a spring about δq = 0 that gives way at τ_f. docs/theory/joint_friction.md.

namespace stiction::dynamics::detail {

/// Hinges and sliders with friction, which all stick.
std::vector<FrictionJoint> find_friction_joints(const world::Model& model);

/// What they stick with in this step: stiffer than their τ_f over the creep that a step may have, or, smoothed, as a barrier of κ has it.
void set_stiction(const world::Model& model, const StepOptions& options, StepWorkspace::Impl& work);

/// Their part of Q and b: stuck ones have hk, sliding ones the force ±τ_f.
void set_friction(const StepOptions& options, StepWorkspace::Impl& work);

/// Rows −side·δq − τ_f/k + z/(hk) ≥ 0 of those that slide.
void add_friction(const StepOptions& options, StepWorkspace::Impl& work);

/// Those whose spring holds more than τ_f at the solution slide in the next round, to the side that gives way; true when there are any. As saturate_motors.
bool slide_joints(StepWorkspace::Impl& work);

/// Forces of the joints on their coordinates.
void read_friction(const world::Model& model, const StepOptions& options, const StepWorkspace::Impl& work, StepResult& out);

}  // namespace stiction::dynamics::detail
