#pragma once

#include <optional>

#include "stiction/planning/expansion.hpp"
#include "stiction/planning/simulate.hpp"

namespace stiction::planning {

/// Simulates the given start with the exact dynamics until no object moves, with the commands u_start (n_a); empty: the joint positions.
/// Overlapping bodies move apart, objects slightly above their support come down, and commands beyond the motors are reduced.
/// @returns the state where the search begins, with knots if the given start does not rest; nothing if it cannot settle (result.reason)
std::optional<Trace> settle_start(const Setting& setting, const Eigen::VectorXd& u_start, ThreadScratch& scratch, Totals& totals,
                                  PlanResult& result);

}  // namespace stiction::planning
