#pragma once

#include <optional>

#include "stiction/planning/expansion.hpp"
#include "stiction/planning/simulate.hpp"

namespace stiction::planning {

/// The given start under the exact dynamics, with the commands u_start (n_a) held, or where the joints are if that is empty, until no object moves. What
/// overlaps is moved apart, what hangs in the air by little comes down, and commands beyond what the motors bear are taken back.
/// @returns where the search begins, with knots if the given start does not rest; nothing where it does not come to rest: result.reason says why
std::optional<Trace> settle_start(const Setting& setting, const Eigen::VectorXd& u_start, ThreadScratch& scratch, Totals& totals,
                                  PlanResult& result);

}  // namespace stiction::planning
