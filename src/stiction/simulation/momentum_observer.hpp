#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "stiction/core/random.hpp"
#include "stiction/world/model.hpp"

namespace stiction::simulation {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// What a momentum observer is given, and how well it knows the robot.
struct ObserverOptions {
  double time_constant = 0.01;  ///< 1/K_O: the estimate follows the external torque with a first-order lag of this [s], > 0
  double noise = 0.05;          ///< standard deviation of each estimate, of white noise of the torque sensors [N m; N], ≥ 0
  double bias = 0;              ///< standard deviation of an offset of each torque sensor, drawn once a run [N m; N], ≥ 0
  double bias_reach =
      0;  ///< distance in joint positions over which offsets change, as those of real arms do with posture [rad; m], ≥ 0; 0: constant
  double inertia_error = 0;  ///< share by which the masses that it knows are too large [-], > −1
  /// Share by which the friction that it takes off is too large, F_c tanh(q̇/v₀) + F_v q̇ of joints that have any, > −1; nullopt: it knows of none,
  /// and friction is external to it.
  std::optional<double> friction_error{};
  /// F_c and F_v of each joint in its place (n): what an arm found of its own friction [N m; N], [N m s/rad; N s/m]; both empty: as `friction_error` says.
  Eigen::VectorXd coulomb{}, viscous{};
  double stiction_speed = 0.01;   ///< v₀ [rad/s or m/s], > 0
  std::uint64_t seed = 0;         ///< of noise and bias
  Eigen::VectorXd joint_noise{};  ///< `noise` of each joint (n); empty: `noise` in all
  Eigen::VectorXd rest{};         ///< what the estimates are where nothing acts, as after a calibration (n) [N m; N]; empty: 0
  Eigen::VectorXd drift{};  ///< of a further offset of each torque sensor, a random walk from 0 (n) [N m/√s; N/√s], ≥ 0; empty: none
  void validate() const;    ///< @throws core::InvalidInput naming the field
};

/// External joint torques from momentum, without accelerations:
///     r = K_O ( p − ∫ (τ + n + r) dt − p₀ ) ,   p = M v ,   n = Cᵀ v − g ,   so that   ṙ = K_O (τ_ext − r) ,                    (C.11)
/// in implicit steps of h:  r ← r + a (Δp/h − τ − n − r),  a = h K_O / (1 + h K_O). White noise of standard deviation s on τ gives r one of s √(a/(2 − a)).
/// Offsets: b_j(q) = ξ_j cos(w_j·q) + η_j sin(w_j·q) with normal ξ, η of deviation `bias` and w of deviation 1/bias_reach, so that at any q they have deviation
/// `bias`, and over a distance d ≪ bias_reach change by d/bias_reach of it.
/// Tests: tests/simulation/momentum_observer_test.cpp. Source: De Luca et al., IROS 2006
class MomentumObserver {
 public:
  /// @param joints  n    @param period  h [s], > 0
  MomentumObserver(Eigen::Index joints, double period, const ObserverOptions& options);

  void reset();  ///< r = 0; the same noise and bias again
  /// One period. @param p  momentum at its end (n)    @param n  mean of Cᵀ v − g over it (n)    @param tau  that the joints bore during it, without noise (n)
  /// @param q  joint positions, of which offsets depend (n)
  const Eigen::VectorXd& update(VectorRef p, VectorRef n, VectorRef tau, VectorRef q);
  /// The momentum from which the next period starts.
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
  Eigen::VectorXd walk_;           ///< offsets that drift
};

}  // namespace stiction::simulation
