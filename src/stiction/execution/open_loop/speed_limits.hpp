#pragma once

#include <Eigen/Core>

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// In which what objects on joints rest on stops them [s]: that gives the box of planar_pushing its published damping.
inline constexpr double kRestTime = 0.05;

/// Way that an object coasts, trails its plan or falls while springs take it up [L].
inline constexpr double kCoast = 0.05;

/// Knots of a trajectory are at least this far apart [s].
inline constexpr double kLeastInterval = 1e-6;

/// Of the weights that speeds follow from, also where a scene has no gravity [m/s²].
inline constexpr double kGravity = 9.81;

/// How fast joints may be commanded to move. Small, because plans know no inertia.
struct SpeedLimits {
  double revolute = 0.1;        ///< while pushing [rad/s], > 0
  double prismatic = 0.0125;    ///< while pushing [m/s], > 0
  double regrasp_factor = 4.0;  ///< regrasps may be this much faster, > 0 …
  double ramp = 0.25;  ///< … where they are more than regrasp_factor times this from their ends, in time at the speed of pushes [s], > 0
  double landing_factor = 0.25;  ///< … and where they leave and reach contact this times as fast, at most regrasp_factor, > 0
  /// Springs of joints change the force at the reach of their joint by no more than the weight that the lightest object with a shape would have under 9.81 m/s² in this
  /// time (E.9) [s], ≥ 0; 0: as fast as comes. An object on a joint weighs as much as friction and damping of the joint give when it goes kCoast in that time, if that
  /// is more: they hold it as a weight would.
  double load_time = 0.5;
  double pause = 4.0;     ///< commands rest this long between pieces [s], ≥ 0
  void validate() const;  ///< @throws core::InvalidInput naming the field

  /// v_j of (E.1), per joint (n_a) while pushing [rad/s or m/s].
  Eigen::VectorXd of_joints(const world::Model& model) const;
  /// Speeds at which springs are strained, per joint (n_a) [rad/s or m/s], for calc_duration of strains u − qᵃ.
  Eigen::VectorXd of_springs(const world::Model& model) const;
};

/// Δt = max_j |u_j − u_before,j| / v_j  (E.1) [s]
double calc_duration(const Eigen::VectorXd& u_before, const Eigen::VectorXd& u, const Eigen::VectorXd& speeds);

}  // namespace stiction::execution
