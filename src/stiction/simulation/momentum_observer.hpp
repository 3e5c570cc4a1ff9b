#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "stiction/core/random.hpp"
#include "stiction/world/model.hpp"

namespace stiction::simulation {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// Options of a momentum observer: its lag, and the errors of its sensors and of its robot model.
struct ObserverOptions {
  double time_constant = 0.01;  ///< 1/K_O, the first-order lag of the estimate [s], > 0
  double noise = 0.05;          ///< standard deviation of each estimate due to white noise of the torque sensors [N m; N], ≥ 0
  double bias = 0;              ///< standard deviation of an offset of each torque sensor, drawn once per run [N m; N], ≥ 0
  double bias_reach =
      0;  ///< distance in joint positions over which offsets change with the posture, as on real arms [rad; m], ≥ 0; 0: constant
  double inertia_error = 0;  ///< share by which the masses in its robot model are too large [-], > −1
  /// Share by which the compensated friction F_c tanh(q̇/v₀) + F_v q̇ is too large, > −1; nullopt: the observer compensates no friction,
  /// and friction appears as external torque.
  std::optional<double> friction_error{};
  /// F_c and F_v of each joint instead (n), as identified on an arm [N m; N], [N m s/rad; N s/m]; both empty: as `friction_error` says.
  Eigen::VectorXd coulomb{}, viscous{};
  double stiction_speed = 0.01;   ///< v₀ [rad/s or m/s], > 0
  std::uint64_t seed = 0;         ///< seed of noise and bias
  Eigen::VectorXd joint_noise{};  ///< `noise` of each joint (n); empty: `noise` in all
  Eigen::VectorXd rest{};         ///< estimates without external torque, as found by a calibration (n) [N m; N]; empty: 0
  Eigen::VectorXd drift{};  ///< rate of a further offset of each torque sensor, a random walk from 0 (n) [N m/√s; N/√s], ≥ 0; empty: none
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// Estimates external joint torques from momentum, without accelerations:
///     r = K_O ( p − ∫ (τ + n + r) dt − p₀ ) ,   p = M v ,   n = Cᵀ v − g ,   so that   ṙ = K_O (τ_ext − r) ,                    (C.11)
/// in implicit steps of h:  r ← r + a (Δp/h − τ − n − r),  a = h K_O / (1 + h K_O). White noise of standard deviation s on τ gives r the
/// deviation s √(a/(2 − a)). Offsets are b_j(q) = ξ_j cos(w_j·q) + η_j sin(w_j·q) with normal ξ, η of deviation `bias` and w of deviation
/// 1/bias_reach. At any q their deviation is `bias`; over a distance d ≪ bias_reach they change by d/bias_reach of `bias`.
/// Tests: tests/simulation/momentum_observer_test.cpp. Source: De Luca et al., IROS 2006
class MomentumObserver {
 public:
  /// @param joints  n    @param period  h [s], > 0
  MomentumObserver(Eigen::Index joints, double period, const ObserverOptions& options);

  void reset();  ///< r = 0; the same noise and bias again
  /// Updates r after one period. @param p  momentum at its end (n)    @param n  mean of Cᵀ v − g during it (n)    @param tau  joint torques during it, without noise (n)
  /// @param q  joint positions, which determine the offsets (n)    @returns r (n)
  const Eigen::VectorXd& update(VectorRef p, VectorRef n, VectorRef tau, VectorRef q);
  /// Sets the momentum from which the next period starts.
  void start(VectorRef p) { p_ = p; }

  const Eigen::VectorXd& external() const { return r_; }  ///< r (n) [N m; N]
  const ObserverOptions& options() const { return options_; }

 private:
  ObserverOptions options_;
  double period_, gain_;
  core::Random random_, random_walk_;
  Eigen::VectorXd sensor_noise_;  ///< (n)
  Eigen::VectorXd p_, r_;
  Eigen::VectorXd cosine_, sine_;  ///< ξ, η
  Eigen::MatrixXd waves_;          ///< rows w_j
  Eigen::VectorXd walk_;           ///< drifting offsets
};

}  // namespace stiction::simulation
