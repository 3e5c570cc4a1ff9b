#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// Something in a task that can be read, and is hardly what was meant.
struct Finding {
  std::string
      kind;  ///< "overlap", "stuck", "force", "unsupported", "hold", "reach", "weight", "motors", "gravity", "size", "visual", "units", "quaternion", "sample_box", "goal"
  std::string message;                   ///< field or body, what was found, what was likely meant
  std::string where{};                   ///< "start" or "goal", where it is a matter of one of them
  std::vector<std::string> names{};      ///< geometries ("body/geometry") or the object that it is about
  std::optional<Eigen::Vector3d> p_W{};  ///< of an overlap or a gap, halfway between the nearest points [m]
  std::optional<double> amount{};        ///< depth of an overlap, width of a gap, or what is missing to reach [m]
};

/// Looks at a task without planning it. Lengths L and forces F are those of world::Scales.
///
/// overlap      two shapes are deeper in each other than 0.01 L of the pair: at the start, and at the goal the object in what does not move
/// stuck        the first step from the start has no solution: an overlap that no joint can undo
/// unsupported  at the start an object that gravity moves touches nothing: nothing is nearer than 0.01 L
/// hold         at the goal it touches nothing that is not a robot, and the robots have neither two bodies nor a flat one to hold it with
/// reach        at the start or at the goal every shape of every robot is farther from the object than its joints allow (lower bound)
/// weight       under F of the object even the stiffest joint gives way by more than L
/// motors       to carry the goal's object, or to push it along what it stands on, takes more force than the motors give (lint_motors.hpp)
/// gravity      it points upwards
/// size         an object is more than ten times as large as the robots reach, or a thousandth of it; a shape of a robot is more than ten
///              times as large as its joints reach
/// visual       a link of a robot that moves is seen and has no collision geometry, nor has what is welded to it
/// units        angles beyond 2π and limits beyond 4π: degrees; tolerances that every pose is within
/// quaternion   quaternion_wxyz reads as a half turn, and as x y z w as something less
/// sample_box   the box leaves out the goal
/// goal         the start is within its tolerances
///
/// @param control  once it is to stop, what takes long is not looked at
/// @returns what was found, in the order above; empty where there is nothing to say
/// Tests: tests/tasks/lint_test.cpp
std::vector<Finding> lint(const Task& task, const core::RunControl& control = {});

}  // namespace stiction::tasks
