#pragma once

#include <memory>

#include "stiction/execution/open_loop/drag_feedforward.hpp"
#include "stiction/execution/open_loop/run_speed.hpp"
#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// A plan in time at these speeds: every piece as fast as speeds and accelerations let it, regrasps from and to the speed of pushes, pushes of
/// what is damped from rest to rest and with their commands ahead of the plan by what the damping takes.                              (E.18), (E.13), (E.17)
/// No command is faster than RunSpeeds::most, leads among them.
/// @param lead   of the model; null: commands are those of the plan
/// @param pause  commands rest this long between pieces [s], ≥ 0
/// @throws core::InvalidInput as make_trajectory()
/// Tests: tests/execution/run_timing_test.cpp
Trajectory make_trajectory(const world::Model& model, const planning::Plan& plan, const RunSpeeds& speeds, DragFeedforward* lead = nullptr,
                           double pause = 0);

/// … at the speeds that follow from the object of its goal and from the motors, and with that lead: what a robot is given that knows nothing of the object.
/// @param speed  times the full timing, > 0; above 1 of pushes alone
Trajectory make_trajectory(const world::Model& model, const planning::Plan& plan, double speed = kOpenLoopSpeed, double pause = 0);

/// Where carrying a plan out begins: at the end of settling (n_q).
/// @throws core::InvalidInput as make_trajectory()
Eigen::VectorXd start_of(const world::Model& model, const planning::Plan& plan);

}  // namespace stiction::execution
