#pragma once

#include "stiction/dynamics/active_set.hpp"

// Internal to the layer: steps with Coulomb's law (S.14), with Anitescu's law as a fallback. docs/theory/step.md.

namespace stiction::dynamics::detail {

/// True if the step uses Coulomb's law. Smoothed steps always use Anitescu's law.
bool is_coulomb(const StepOptions& options);

/// Solves an exact step with the friction law of the options. If no solution of Coulomb's law is found, the step is bitwise the step of
/// Anitescu's law, because the rounds restart from the rows that Anitescu's law starts with.
/// @returns as solve_rounds()
core::Status solve_by_law(const StepProgram& program, StepWorkspace::Impl& work, int& iterations);

}  // namespace stiction::dynamics::detail
