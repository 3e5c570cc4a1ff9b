#pragma once

#include <vector>

#include "stiction/sensing/link_torque.hpp"

namespace stiction::sensing {

/// Motion and motor torques of the robots, one column per moment.
struct MotionRecord {
  std::vector<double> times;  ///< increasing [s]
  Eigen::MatrixXd q;          ///< (n_a × moments) [rad or m]
  Eigen::MatrixXd v;          ///< (n_a × moments) joint velocities [rad/s or m/s]
  Eigen::MatrixXd tau;        ///< (n_a × moments) torques of the motors on the links [N·m; N]
};

/// Friction of each joint, F_c tanh(q̇/v₀) + F_v q̇, and an offset of its torque sensor (n_a each).
struct JointFriction {
  Eigen::VectorXd coulomb;                  ///< F_c [N·m; N]
  Eigen::VectorXd viscous;                  ///< F_v [N·m s/rad; N s/m]
  Eigen::VectorXd offset;                   ///< [N·m; N]
  double stiction_speed = 0.01;             ///< v₀, speed below which the sign of friction is uncertain [rad/s or m/s], > 0
  Eigen::VectorXd left{};                   ///< standard deviation of the residual torques of the fit, noise included [N·m; N]
  Eigen::VectorXd calc(VectorRef v) const;  ///< friction torque plus offset (n_a)
};

struct ObserverSettings {
  double time_constant = 0.02;              ///< 1/K of the observer [s], > 0
  const JointFriction* friction = nullptr;  ///< nullptr: no friction
};

/// Computes external torques without accelerations, by the momentum observer (De Luca & Mattone 2003): with p = M q̇ and ṗ = τ + C(q, q̇)ᵀ
/// q̇ − g − τ_f + τ_ext,
///     r = K (p(t) − p(0) − ∫ (τ + Cᵀq̇ − g − τ_f + r) dt) ,   ṙ = K (τ_ext − r) .                                        (Y.18)
/// M contains only the links, as stated in the robot's file, without rotors. Cᵀq̇ = ∂/∂q ½ q̇ᵀM q̇ comes from central differences. r starts
/// at 0.
/// @returns r (n_a × moments) [N·m; N]  @throws core::InvalidInput: sizes, not finite, times that do not increase, links without mass, settings
/// Tests: tests/sensing/observer_test.cpp
Eigen::MatrixXd observe(const world::Model& model, const MotionRecord& record, const ObserverSettings& settings = {});

/// Identifies friction from motion without contact: fits r of an observer without friction by least squares to the low-passed tanh(q̇/v₀),
/// q̇ and 1. Rows in which a joint sticks are left out. Friction is not negative.
/// @throws core::InvalidInput: as observe(); a joint that does not move in both directions, named
JointFriction identify_friction(const world::Model& model, const MotionRecord& record, double time_constant = 0.02,
                                double stiction_speed = 0.01);

/// The same from the output of an observer without friction. @param v, r  joint velocities and observer output (n_a × moments)
JointFriction fit_friction(const world::Model& model, const std::vector<double>& times, const Eigen::MatrixXd& v, const Eigen::MatrixXd& r,
                           double time_constant, double stiction_speed = 0.01);

}  // namespace stiction::sensing
