#pragma once

#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "stiction/execution/touch/guarded_run.hpp"

namespace stiction::app {

/// Forces from 0.1 s after contact on, against the one that a move asks for in the end, of all others against the bound of the controller.
bool is_gentle(const execution::TouchScenario& scenario, const execution::GuardedRunResult& r, double tolerance);

/// What became of guarded moves, in words and as an object.
void print_moves(std::FILE* to, const execution::TouchScenario& scenario, const execution::GuardedRunResult& r, bool gentle);
nlohmann::ordered_json report_moves(const execution::TouchScenario& scenario, const execution::GuardedRunResult& r, std::uint64_t seed,
                                    bool gentle, double wall_s);

}  // namespace stiction::app
