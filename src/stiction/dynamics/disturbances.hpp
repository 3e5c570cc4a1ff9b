#pragma once

#include <Eigen/Core>

#include "stiction/world/model.hpp"
#include "stiction/world/robot_chains.hpp"

// Disturbed inputs of steps, four draws of each kind, for robustness tests of edges: docs/theory/verification.md.

namespace stiction::dynamics {

/// Number of draws of each kind.
constexpr int kDisturbances = 4;

/// Computes the extra force on free objects if gravity g is tilted by `angle`: m ‖g‖ tan(angle) s, with s ⊥ g and ‖s‖ = 1. The direction s
/// turns by a quarter from one draw to the next.
/// @param q      configuration (n_q)  @param angle  [rad], in [0, π/2)  @param draw  in [0, kDisturbances)
/// @returns      generalised force (n_v) [N, N·m]; 0 without gravity, and for objects on joints, because their joints carry them
Eigen::VectorXd calc_weights_aside(const world::Model& model, const Eigen::VectorXd& q, double angle, int draw);

/// Computes factors on μ, each 1 or 1 − share. There are three groups of pairs: pairs without a robot, pairs of every second branch, and
/// pairs of the branches between. Each group has the smaller factor in two draws, and any two groups differ in two draws: a half fraction
/// of a two-level design.
/// @param share  in [0, 1)  @param draw  in [0, kDisturbances)
/// @returns      one factor per pair of the model
Eigen::VectorXd calc_friction_factors(const world::Model& model, const world::RobotChains& chains, double share, int draw);

}  // namespace stiction::dynamics
