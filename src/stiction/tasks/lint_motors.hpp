#pragma once

#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/tasks/lint.hpp"

namespace stiction::tasks {

/// "motors": the goal's object has to be carried, or pushed along what it stands on, and the motors' efforts do not give the force for it.
///
/// Needed, with W the weight of the object and all that hangs on it:
///   carried   W, where the goal is away from everything but the links that move
///   pushed    min(μ, a/D)·W, where it stands at the start and at the goal and these are apart: it slides, or tips about an edge a away from the vertical
///             through its centre of mass by a force that acts D at most away from it. Nothing for what stands on fewer than three points, which may roll.
/// Given: the largest force of contacts inside their friction cones with |J_jᵀλ| ≤ effort_j in every joint, upwards (carried) or in any direction (pushed), the best contact
/// of every branch added up, over postures in contact that are drawn at the goal (carried) or at the start (pushed). Equilibrium in the other directions is not asked for, so that
/// what is said to be too little is.
///
/// Says nothing where the weakest joint at its full reach gives enough, and where hardly a posture is found.
/// Tests: tests/tasks/lint_motors_test.cpp
void lint_motors(const Task& task, const core::RunControl& control, std::vector<Finding>& out);

}  // namespace stiction::tasks
