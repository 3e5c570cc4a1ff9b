#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "stiction/planning/plan.hpp"

namespace stiction::planning::refinement {

/// A plan whose objects are elsewhere, each by its own shift s, and whose robots touch them at the same places. Where a push has points p_c of links near an object, the joints
/// move by
///     δ = argmin Σ_c a_c (‖p_c(q + δ) − p_c(q) − s_c‖² + w² ‖log R_c(q + δ) R_c(q)ᵀ‖²) + ε² ‖δ‖² ,                                 (G.7)
/// with R_c of the link and a_c that falls with the distance of the point, and commands by the same δ, so that springs keep their strain. Elsewhere δ follows from the two nearest such states in proportion to the steps between them.
/// @param shifts  of every object of the model [m]  @throws core::InvalidInput: sizes; an object that does not move freely and has a shift
/// Tests: tests/planning/carry_test.cpp
Plan shift_plan(const world::Model& model, const Plan& plan, const std::vector<Eigen::Vector3d>& shifts);

}  // namespace stiction::planning::refinement
