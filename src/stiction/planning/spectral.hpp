#pragma once

#include <Eigen/Core>

namespace stiction::planning {

/// Directions of the robot that move the objects along the principal axes of their reachable set {B δu : ‖δu‖ ≤ 1}: the columns v_k of V in
/// B = UΣVᵀ, those with the largest σ_k first, without those of σ_k ≤ 1e-5 σ_1. Unit columns; which of ±v_k is not specified.
/// @param B  (m × n)  @returns (n × rank), no column for B = 0
Eigen::MatrixXd principal_directions(const Eigen::MatrixXd& B);

}  // namespace stiction::planning
