#pragma once

#include <vector>

#include "stiction/execution/open_loop/run_speed.hpp"
#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// Adds to the commands the lead e by which springs K with the damping D accelerate the robot as planned. A motor that gives K(u + e − q) + D(u̇ + ė − q̇) follows
/// q = u if
///
///     D_j ė_j + K_j e_j = (M(q) q̈)_j ,     D_j = 2 √(K_j M_jj(q))                                                                    (E.28)
///
/// Accelerations count up to what motors give (RunSpeeds::most_room), and where free motion goes on: contact ends it. In other intervals e fades away, and the
/// last command has no lead. No command becomes faster than RunSpeeds::most_free.
/// @param free  per knot: the robot moves freely on the way to it
/// Tests: tests/execution/run_timing_test.cpp
void add_inertia_lead(const world::Model& model, const std::vector<char>& free, const RunSpeeds& speeds, Trajectory& trajectory);

}  // namespace stiction::execution
