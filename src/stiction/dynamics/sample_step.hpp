#pragma once

#include <Eigen/Core>

#include "stiction/dynamics/step.hpp"

// Internal to the layer: one of many exact steps from the same q.

namespace stiction::dynamics::detail {

/// step() where δq is known roughly: an exact step looks first at the rows that this motion violates or nearly does, not at all within reach.
/// The result is that of step(), up to its tolerances, without contacts.
/// @param guess  of δq (n_v)
core::Status sample_step(const world::Model& model, const StepInput& in, const Eigen::VectorXd& guess, const StepOptions& options,
                         StepWorkspace& work, StepResult& out);

}  // namespace stiction::dynamics::detail
