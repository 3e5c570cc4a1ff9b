#pragma once

#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/tasks/lint.hpp"

namespace stiction::tasks {

/// Reports "motors": the goal's object must be carried, or pushed along its support, and the motors' efforts cannot give the force for it.
///
/// Required force, with W the weight of the object and all objects that hang on it:
///   carried   W, if at the goal the object is away from everything but moving links
///   pushed    min(μ, a/D)·W, if the object stands at the start and at a different goal. It slides, or tips about an edge at distance a
/// from
///             the vertical through its centre of mass, by a force at a lever arm of at most D. An object on fewer than three support
/// points
///             may roll and needs no force.
/// Available force: the largest contact force inside the friction cone with |J_jᵀλ| ≤ effort_j in every joint, upwards (carried) or in any
/// direction (pushed). The best contacts of all branches are added up, and the maximum is taken over sampled postures in contact at the
/// goal (carried) or at the start (pushed). Equilibrium in the other directions is not required, so a reported lack of force is certain.
///
/// Reports nothing if the weakest joint at its full reach gives enough force, or if too few postures are found.
/// Tests: tests/tasks/lint_motors_test.cpp
void lint_motors(const Task& task, const core::RunControl& control, std::vector<Finding>& out);

}  // namespace stiction::tasks
