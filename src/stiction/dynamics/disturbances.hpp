#pragma once

#include <Eigen/Core>

#include "stiction/world/model.hpp"
#include "stiction/world/robot_chains.hpp"

// Inputs of steps that go otherwise than planned, four times over: docs/theory/verification.md.

namespace stiction::dynamics {

/// Draws of each kind.
constexpr int kDisturbances = 4;

/// What objects that move freely feel besides gravity g when it comes from `angle` aside: the force m ‖g‖ tan(angle) s, with s ⊥ g, ‖s‖ = 1, turned by
/// a quarter from one draw to the next.
/// @param q      configuration (n_q)  @param angle  [rad], in [0, π/2)  @param draw  in [0, kDisturbances)
/// @returns      generalised force (n_v) [N, N·m]; 0 without gravity and for objects on joints, which something carries
Eigen::VectorXd calc_weights_aside(const world::Model& model, const Eigen::VectorXd& q, double angle, int draw);

/// Factors of μ, 1 or 1 − share. Three groups of pairs, those without a robot, those of every second branch and those of the branches between, have
/// the smaller one in two of the draws each, and any two of them differ in two draws: a half fraction of a two-level design.
/// @param share  in [0, 1)  @param draw  in [0, kDisturbances)
/// @returns      (pairs of the model)
Eigen::VectorXd calc_friction_factors(const world::Model& model, const world::RobotChains& chains, double share, int draw);

}  // namespace stiction::dynamics
