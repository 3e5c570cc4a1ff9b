#pragma once

#include "stiction/dynamics/active_set.hpp"

// Internal to the layer: Coulomb's law (S.14), and the step of Anitescu's law in its place. docs/theory/step.md.

namespace stiction::dynamics::detail {

/// Smoothed steps have Anitescu's law whatever the options say.
bool is_coulomb(const StepOptions& options);

/// Solves an exact step by the friction law that the options name. Where Coulomb's law is not found the step is Anitescu's to the last digit: its rounds start from
/// the rows with which they would start without Coulomb's law.
/// @returns as solve_rounds()
core::Status solve_by_law(const StepProgram& program, StepWorkspace::Impl& work, int& iterations);

}  // namespace stiction::dynamics::detail
