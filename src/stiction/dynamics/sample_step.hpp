#pragma once

#include <Eigen/Core>

#include "stiction/dynamics/step.hpp"

// Internal to the layer: one of many exact steps from the same q.

namespace stiction::dynamics::detail {

/// Does step() when an approximate δq is known. An exact step starts with the rows that this motion violates or nearly violates, instead of
/// all rows within reach; a smoothed step starts at this motion. The result is that of step() up to its tolerances, but without contacts
/// unless A is asked for.
/// @param guess  approximate δq (n_v)
core::Status sample_step(const world::Model& model, const StepInput& in, const Eigen::VectorXd& guess, const StepOptions& options,
                         StepWorkspace& work, StepResult& out);

}  // namespace stiction::dynamics::detail
