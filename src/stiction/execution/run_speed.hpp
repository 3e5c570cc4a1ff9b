#pragma once

#include "stiction/planning/trajectory.hpp"

namespace stiction::execution {

/// How fast a robot handles an object in the world.
struct RunSpeeds {
  Eigen::VectorXd push;       ///< of joints while pushing, and where regrasps leave and reach contact (n_a) [rad/s or m/s], > 0
  Eigen::VectorXd most;       ///< what no joint exceeds (n_a) [rad/s or m/s], > 0, may be infinite
  Eigen::VectorXd springs;    ///< at which springs are strained (n_a) [rad/s or m/s], > 0 (E.9)
  double regrasp_factor = 4;  ///< regrasps may be this much faster than pushes, ≥ 1 …
  double ramp = 0.025;        ///< … as they are farther from their ends: by 1 for each such time at the speed of pushes (E.8) [s], > 0
  void validate(const world::Model& model) const;  ///< @throws core::InvalidInput naming the field
};

/// In which what a robot pushes follows its commands [s]: D/K of an object of mass m on a joint that is damped by m/τ, pushed by the softest spring; 0 of
/// one that moves freely.                                                                                                                    (E.14)
double calc_follow_time(const world::Model& model, int object);

/// Speeds from sizes, friction and the motors (E.13). Quasi-static plans hold as long as the object stops within a small share of its length when nothing
/// pushes it any more, and trails its plan by no more.
/// @param factor  of the speeds of pushes, > 0
/// Tests: tests/execution/run_test.cpp
RunSpeeds calc_run_speeds(const world::Model& model, int object, double factor = 1);

/// A plan in time at these speeds: as planning::make_trajectory(), without pauses.
/// @throws core::InvalidInput as that
planning::Trajectory make_trajectory(const world::Model& model, const planning::Plan& plan, const RunSpeeds& speeds);

}  // namespace stiction::execution
