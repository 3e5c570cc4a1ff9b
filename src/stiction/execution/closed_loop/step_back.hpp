#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// The way of the robots off everything, where each object that they touch stands on something that does not move, or is kept by its joint or its plane: an object
/// that leans on a finger, and has no rest that a plan could begin at, then falls back onto what it stands on, and one that a finger wedges is free again.
/// @param q  measured configuration (n_q)
/// @returns postures (n_a each) [rad, m]; none where an object would be dropped, nothing is touched, or joint limits leave no way
/// Tests: tests/execution/step_back_test.cpp
std::vector<Eigen::VectorXd> find_step_back(const world::Model& model, Eigen::VectorXd q);

}  // namespace stiction::execution
