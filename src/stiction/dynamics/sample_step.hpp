#pragma once

#include <Eigen/Core>

#include "stiction/dynamics/step.hpp"

// Internal to the layer: one of many exact steps from the same q.

namespace stiction::dynamics::detail {

/// step() where δq is known roughly: an exact step looks first at the rows that this motion violates or nearly does, not at all within reach, and a
/// smoothed step begins there. The result is that of step(), up to its tolerances, without contacts where A is not asked for.
/// @param guess  of δq (n_v)
core::Status sample_step(const world::Model& model, const StepInput& in, const Eigen::VectorXd& guess, const StepOptions& options,
                         StepWorkspace& work, StepResult& out);

}  // namespace stiction::dynamics::detail
