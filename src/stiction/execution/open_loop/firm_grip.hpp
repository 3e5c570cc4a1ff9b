#pragma once

#include <vector>

#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// For each knot of a trajectory, whether robots alone hold an object that can fall, there or at another knot of the same push: a push that lifts an object has
/// gripped it from its beginning, unless the object lies in a hand.
std::vector<char> find_carried(const world::Model& model, const Trajectory& trajectory);

/// Tightens the grips of a trajectory. A plan may loosen its grip on the way until forces of some weights hold the object, which then falls for small errors of
/// the posture. In pushes in which robots alone hold an object, the strain of their springs is therefore scaled up to the preload F₀ of (P.11):
///
///     u ← qᵃ + max(1, F₀ / max_j (K_j |u_j − qᵃ_j| / r_j)) (u − qᵃ)                                                                  (E.27)
///
/// Contact forces grow by the same factor and keep their directions, apart from the small share that carries the weight.
/// @param carried  of find_carried()
/// Tests: tests/execution/firm_grip_test.cpp
void tighten_grips(const world::Model& model, const std::vector<char>& carried, Trajectory& trajectory);

}  // namespace stiction::execution
