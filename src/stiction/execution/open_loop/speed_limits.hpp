#pragma once

#include <Eigen/Core>

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Rest time τ in which an object on a joint comes to rest [s]; this value gives the box of planar_pushing its published damping.
inline constexpr double kRestTime = 0.05;

/// Largest distance that an object coasts, trails its plan, or falls while springs take it up [L].
inline constexpr double kCoast = 0.05;

/// The plan waits while a joint is off its path by more than this, and motors without a stated effort lead by no more [joint units].                 (E.25), (E.17)
inline constexpr double kStray = 0.3;

/// Least time between two knots of a trajectory [s].
inline constexpr double kLeastInterval = 1e-6;

/// Gravity for the weights from which speeds follow, also in a scene without gravity [m/s²].
inline constexpr double kGravity = 9.81;

/// Speed limits of joint commands. They are small because plans know no inertia.
struct SpeedLimits {
  double revolute = 0.1;        ///< while pushing [rad/s], > 0
  double prismatic = 0.0125;    ///< while pushing [m/s], > 0
  double regrasp_factor = 4.0;  ///< factor by which regrasps may be faster than pushes, > 0
  double ramp = 0.25;  ///< regrasps are this fast if more than regrasp_factor times this from their ends, in time at push speed [s], > 0
  double landing_factor = 0.25;  ///< speed factor where regrasps leave and reach contact, at most regrasp_factor, > 0
  /// Load time T_l: the force of a joint spring at the reach of its joint changes in this time by no more than the weight that the lightest object with a shape
  /// would have under 9.81 m/s² (E.9) [s], ≥ 0; 0: no limit. For an object on a joint, the weight is at least the force of friction and damping of the joint
  /// when it moves kCoast in this time, since they hold the object as a weight would.
  double load_time = 0.5;
  double pause = 4.0;     ///< commands rest this long between pieces [s], ≥ 0
  void validate() const;  ///< @throws core::InvalidInput naming the field

  /// v_j of (E.1): speed of each joint while pushing (n_a) [rad/s or m/s].
  Eigen::VectorXd of_joints(const world::Model& model) const;
  /// Strain rate of each joint spring (n_a) [rad/s or m/s], for calc_duration of strains u − qᵃ.
  Eigen::VectorXd of_springs(const world::Model& model) const;
};

/// Duration of a command change at the given speeds: Δt = max_j |u_j − u_before,j| / v_j  (E.1) [s]
double calc_duration(const Eigen::VectorXd& u_before, const Eigen::VectorXd& u, const Eigen::VectorXd& speeds);

}  // namespace stiction::execution
