#pragma once

#include <Eigen/Core>

#include "stiction/world/model.hpp"

namespace stiction::dynamics {

/// Number of sides to which gravity is tilted.
constexpr int kSides = 4;

/// Computes the extra force on free objects if gravity g is tilted by `angle`: m ‖g‖ tan(angle) s, with s ⊥ g and ‖s‖ = 1. The direction s
/// turns by a quarter from one side to the next.
/// @param q      configuration (n_q)  @param angle  [rad], in [0, π/2)  @param side  in [0, kSides)
/// @returns      generalised force (n_v) [N, N·m]; 0 without gravity, and for objects on joints, because their joints carry them
Eigen::VectorXd calc_weights_aside(const world::Model& model, const Eigen::VectorXd& q, double angle, int side);

}  // namespace stiction::dynamics
