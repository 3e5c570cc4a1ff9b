#pragma once

#include "stiction/execution/touch/guarded_run.hpp"

// Internal to the layer.

namespace stiction::execution {

/// Identifies the joint friction of an arm before its moves. Each joint moves to and fro about the start by A = `friction_motion`, with a frequency of its own,
///     q_j = q₀ + A sin²(π t/T) sin(2π f_j t) ,                                                                   (G.6)
/// and fit_friction() fits the rows of an observer without friction. Nothing may be within reach. During the moves, the observer subtracts this friction.
/// @param out  its world must be set; receives `friction` and the status, and a reason if torques were neither friction nor noise, or the run is over
/// @returns Solved | as run_guarded(): the simulation stopped, or the time is over
/// Tests: tests/execution/guarded_friction_test.cpp
[[nodiscard]] core::Status find_friction(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out);

}  // namespace stiction::execution
