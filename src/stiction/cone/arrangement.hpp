#pragma once

#include "stiction/cone/rows.hpp"
#include "stiction/cone/solver.hpp"

// Internal to the layer: maps rows between the order of a problem and the order of the solver, which sorts rows by support in groups of
// four.

namespace stiction::cone::detail {

template <int R>
V4 slack_of_group(const V4 (&w)[R]) {
  if constexpr (R == 1)
    return w[0];
  else
    return w[0] - sqrt(w[1] * w[1] + w[2] * w[2]);
}

/// Patterns, order and weights of a problem (everything but the start).
void prepare(const Problem& problem, const Options& options, State& s);

/// Remembers a solved problem for the next warm start.
void remember(const Problem& problem, const Options& options, State& s);

/// Writes the iterate into the result, in the caller's order. @returns largest distance outside the cones
double write_result(const Problem& problem, const State& s, Result& result);

}  // namespace stiction::cone::detail
