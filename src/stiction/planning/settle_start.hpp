#pragma once

#include <optional>

#include "stiction/planning/edge_simulator.hpp"

namespace stiction::planning {

/// Where a search begins: the given start at rest.
struct SettledStart {
  Eigen::VectorXd q, u;
  std::vector<dynamics::Knot> knots;  ///< from the given start; none where that rests
};

/// The given start under the exact dynamics, with the commands u_start (n_a) held, or where the joints are if that is empty, until no object moves. What overlaps is moved apart, what hangs in the
/// air by little comes down, and commands beyond what the motors bear are taken back.
/// @returns nothing where it does not come to rest: result.reason says why
std::optional<SettledStart> settle_start(const Setting& setting, const Eigen::VectorXd& u_start, const EdgeSimulator& simulator,
                                         ThreadScratch& scratch, Totals& totals, PlanResult& result);

}  // namespace stiction::planning
