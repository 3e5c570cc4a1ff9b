#pragma once

#include <string>

#include "stiction/core/status.hpp"
#include "stiction/sensing/scenario.hpp"

namespace stiction::execution {

/// Simulates the robot of a scenario with `poke`: joint springs hold or move it while it is pushed, and a momentum observer (C.11) says what torques act
/// on it; with base_wrench a sensor under the base what the pushes add there. Fills scenario.series; a scenario without `poke` stays as it is.
/// @returns Solved | NumericalFailure: the simulation broke down, `message` says how
/// @throws core::InvalidInput: options of the observer, a period that is not whole ones of the springs
/// Tests: tests/execution/poke_test.cpp
[[nodiscard]] core::Status simulate_poke(sensing::Scenario& scenario, std::string& message);

}  // namespace stiction::execution
