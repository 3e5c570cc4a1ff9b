#pragma once

#include <string>

#include "stiction/core/status.hpp"
#include "stiction/sensing/scenario.hpp"

namespace stiction::execution {

/// Simulates the robot of a scenario with `poke`: joint springs hold or move the robot while it is pushed, and a momentum observer (C.11) gives the external
/// torques. With base_wrench, a sensor under the base measures what the pushes add there. Fills scenario.series; a scenario without `poke` stays unchanged.
/// @returns Solved | NumericalFailure: the simulation stopped, `message` says why
/// @throws core::InvalidInput: invalid options of the observer, or a period that is not a multiple of the springs' period
/// Tests: tests/execution/poke_test.cpp
[[nodiscard]] core::Status simulate_poke(sensing::Scenario& scenario, std::string& message);

}  // namespace stiction::execution
