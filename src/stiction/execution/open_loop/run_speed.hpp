#pragma once

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Share of the full timing (E.13) at which plans are exported, simulated and written where nobody asks for another one. Without feedback nine planar plans
/// in ten reach their goal at this speed, and one in five at the full timing (docs/theory/execution.md).
inline constexpr double kOpenLoopSpeed = 0.1;

/// How fast a robot handles an object in the world.
struct RunSpeeds {
  double factor = 1;             ///< these speeds are so many times those of the full timing (E.13), > 0
  double object = 0;             ///< of what is pushed, and of the robot where it touches it [m/s], > 0 (E.13)
  double unled = 1;              ///< share of it that is slow enough without a lead, in (0, 1] (E.13)
  Eigen::VectorXd push;          ///< of joints at most, where regrasps leave and reach contact (n_a) [rad/s or m/s], > 0 (E.13)
  Eigen::VectorXd most;          ///< what no joint exceeds (n_a) [rad/s or m/s], > 0, may be infinite
  Eigen::VectorXd springs;       ///< at which springs are strained that bear nothing (n_a) [rad/s or m/s], > 0 (E.9) …
  Eigen::VectorXd spring_time;   ///< … and in which they change by what their branch bears (n_a) [s], > 0 (E.24)
  double room = 0;               ///< that regrasps leave everywhere to lag in [m], > 0 (E.18) …
  Eigen::VectorXd acceleration;  ///< … and what joints follow in it: at this (n_a) [rad/s² or m/s²], > 0, may be infinite …
  Eigen::VectorXd jump;          ///< … with these jumps of their speed at corners (n_a) [rad/s or m/s], > 0, may be infinite
  Eigen::VectorXd most_room;     ///< motors let a joint make use of no more, at its reach (n_a) [m], > 0, may be infinite
  Eigen::VectorXd
      carry_acceleration;  ///< of joints while robots alone hold a free object (n_a) [rad/s² or m/s²], > 0, may be infinite (E.26) …
  Eigen::VectorXd carry_jump;                      ///< … and jumps of their speed (n_a) [rad/s or m/s], > 0, may be infinite
  double start_time = 0;                           ///< in which pushes come to their speed, and to rest [s], ≥ 0
  void validate(const world::Model& model) const;  ///< @throws core::InvalidInput naming the field
};

/// In which what a robot pushes follows its commands [s]: D/K of an object of mass m on a joint that is damped by m/τ, pushed by the softest spring; 0 of
/// one that moves freely.                                                                                                                    (E.14)
double calc_follow_time(const world::Model& model, int object);

/// Speeds from sizes, friction and the motors. Quasi-static plans hold as long as the object stops within a small share of its length when nothing
/// pushes it any more, and trails its plan by no more (E.13); what moves freely follows its commands within the room that its path keeps (E.18).
/// @param factor  of the speeds of pushes, > 0; below 1 of all others as well
/// Tests: tests/execution/run_test.cpp
RunSpeeds calc_run_speeds(const world::Model& model, int object, double factor = 1);

}  // namespace stiction::execution
