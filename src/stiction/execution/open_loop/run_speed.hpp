#pragma once

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Default share of the full speed (E.13) at which plans are exported, simulated and written. Without feedback, two of three plans of planar tasks and of two
/// arms hold at this speed, and one in three at the full speed (docs/theory/execution.md).
inline constexpr double kOpenLoopSpeed = 0.1;

/// Speed and acceleration limits at which a robot handles an object.
struct RunSpeeds {
  double factor = 1;             ///< factor of these speeds over those of the full speed (E.13), > 0
  double object = 0;             ///< speed of a pushed object, and of the robot where it touches the object [m/s], > 0 (E.13)
  double unled = 1;              ///< share of `object` at which pushes need no lead, in (0, 1] (E.13)
  Eigen::VectorXd push;          ///< joint speeds where regrasps leave and reach contact (n_a) [rad/s or m/s], > 0 (E.13)
  Eigen::VectorXd most;          ///< speed limits of joints (n_a) [rad/s or m/s], > 0, may be infinite
  Eigen::VectorXd springs;       ///< strain rate of unloaded springs (n_a) [rad/s or m/s], > 0 (E.9)
  Eigen::VectorXd spring_time;   ///< T_j, time constant of strain rates under the load of their branch (n_a) [s], > 0 (E.24)
  double room = 0;               ///< clearance of regrasps, available for tracking lag [m], > 0 (E.18)
  Eigen::VectorXd acceleration;  ///< acceleration of joints with this lag (n_a) [rad/s² or m/s²], > 0, may be infinite
  Eigen::VectorXd jump;          ///< speed jump of joints at corners with this lag (n_a) [rad/s or m/s], > 0, may be infinite
  Eigen::VectorXd most_room;     ///< largest lag that the motor allows, at the reach of the joint (n_a) [m], > 0, may be infinite
  /// Joint acceleration while only robots hold a free object (n_a) [rad/s² or m/s²], > 0, may be infinite (E.26).
  Eigen::VectorXd carry_acceleration;
  Eigen::VectorXd carry_jump;                      ///< joint speed jump in this case (n_a) [rad/s or m/s], > 0, may be infinite
  double start_time = 0;                           ///< time in which pushes reach their speed, and come to rest [s], ≥ 0
  void validate(const world::Model& model) const;  ///< @throws core::InvalidInput naming the field
};

/// Follow time T_f in which an object trails the commands that push it [s]: D/K for an object of mass m on a joint with the damping m/τ, pushed by the softest
/// spring; 0 for a free object.                                                                                                             (E.14)
double calc_follow_time(const world::Model& model, int object);

/// Computes the speeds from sizes, friction and motors. A quasi-static plan holds if the object stops within a small share of its length when nothing pushes it
/// any more, and trails its plan by no more (E.13). In free motion, joints must follow their commands within the clearance of their path (E.18).
/// @param factor  factor of the speeds of pushes, > 0; below 1 it slows all other motions as well
/// Tests: tests/execution/run_test.cpp
RunSpeeds calc_run_speeds(const world::Model& model, int object, double factor = 1);

}  // namespace stiction::execution
