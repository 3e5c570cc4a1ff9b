#pragma once

#include "stiction/execution/touch/guarded_run.hpp"

// Internal to the layer.

namespace stiction::execution {

/// The friction of the joints of an arm before its moves. Each joint goes to and fro about the start by A = `friction_motion`, with a frequency of its own,
///     q_j = q₀ + A sin²(π t/T) sin(2π f_j t) ,                                                                   (G.6)
/// and the rows of an observer that knows of no friction are fitted by fit_friction(). Nothing may be in reach. The observer of the moves then takes this friction off.
/// @param out  with its world; gets `friction` and the status, and a reason where torques were neither friction nor noise, or the run is over
/// @returns Solved | as run_guarded(): the simulation stopped, or the time is over
/// Tests: tests/execution/guarded_friction_test.cpp
[[nodiscard]] core::Status find_friction(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out);

}  // namespace stiction::execution
