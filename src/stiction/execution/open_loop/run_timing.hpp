#pragma once

#include <memory>

#include "stiction/execution/open_loop/drag_feedforward.hpp"
#include "stiction/execution/open_loop/run_speed.hpp"
#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// Times a plan within the given limits. Every piece is as fast as speeds and accelerations allow. Regrasps begin and end at the speed of pushes. Pushes of
/// damped objects begin and end at rest, and their commands lead the plan to compensate the damping.                                  (E.18), (E.13), (E.17)
/// No command, its lead included, is faster than RunSpeeds::most.
/// @param lead   feed-forward for this model; null: the commands are those of the plan
/// @param pause  commands rest this long between pieces [s], ≥ 0
/// @throws core::InvalidInput as make_trajectory()
/// Tests: tests/execution/run_timing_test.cpp
Trajectory make_trajectory(const world::Model& model, const planning::Plan& plan, const RunSpeeds& speeds, DragFeedforward* lead = nullptr,
                           double pause = 0);

/// Times a plan at the speeds that follow from the object of its goal and from the motors, with the lead. For robots that have no feedback from the object.
/// @param speed  factor of the full speed, > 0; above 1 it applies to pushes only
Trajectory make_trajectory(const world::Model& model, const planning::Plan& plan, double speed = kOpenLoopSpeed, double pause = 0);

/// Configuration at which the execution of a plan begins: the end of its settling (n_q).
/// @throws core::InvalidInput as make_trajectory()
Eigen::VectorXd start_of(const world::Model& model, const planning::Plan& plan);

}  // namespace stiction::execution
