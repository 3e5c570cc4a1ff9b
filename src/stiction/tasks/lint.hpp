#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// A finding: something in a task that is valid but probably not intended.
struct Finding {
  std::string
      kind;  ///< one of "overlap", "stuck", "force", "unsupported", "hold", "reach", "weight", "motors", "gravity", "size", "visual", "units", "quaternion", "sample_box", "goal"
  std::string message;                   ///< field or body, what was found, and what was probably meant
  std::string where{};                   ///< "start" or "goal" if the finding concerns one of them
  std::vector<std::string> names{};      ///< geometries ("body/geometry") or object concerned
  std::optional<Eigen::Vector3d> p_W{};  ///< for an overlap or a gap: midpoint of the nearest points [m]
  std::optional<double> amount{};        ///< depth of an overlap, width of a gap, or distance missing to reach [m]
};

/// Checks a task for likely mistakes without planning it. Lengths L and forces F are those of world::Scales.
///
/// overlap      two shapes penetrate by more than 0.01 L of the pair, at the start; at the goal, the object and a fixed body
/// stuck        the first step from the start has no solution: an overlap that no joint can undo
/// unsupported  at the start an object that gravity moves touches nothing: no other body is nearer than 0.01 L
/// hold         at the goal the object touches nothing but robots, and the robots have neither two bodies nor a flat one to hold it with
/// reach        at the start or at the goal every shape of every robot is farther from the object than its joints allow (lower bound)
/// weight       under F of the object even the stiffest joint gives way by more than L
/// motors       the motors cannot give the force to carry the goal's object, or to push it along its support (lint_motors.hpp)
/// gravity      gravity points upwards
/// size         an object is larger than ten times the reach of the robots, or smaller than a thousandth of it; a shape of a robot is
/// larger
///              than ten times the reach of its joints
/// visual       a moving link of a robot has visual geometry, but neither it nor a link welded to it has collision geometry
/// units        angles beyond 2π and limits beyond 4π, probably degrees; tolerances that every pose satisfies
/// quaternion   quaternion_wxyz is a half turn, but read as x y z w it is a smaller rotation
/// sample_box   the sampling box does not contain the goal
/// goal         the start is within the tolerances of the goal
///
/// @param control  if it asks to stop, long checks are skipped
/// @returns findings in the order above; empty if there are none
/// Tests: tests/tasks/lint_test.cpp
std::vector<Finding> lint(const Task& task, const core::RunControl& control = {});

}  // namespace stiction::tasks
