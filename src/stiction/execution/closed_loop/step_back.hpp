#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Finds a motion of the robots off all objects that they touch, provided each of these objects stands on a fixed body or is kept by its joint or its plane.
/// An object that leans on a finger has no state of rest at which a plan could begin: it then falls back onto its support. A wedged object is freed.
/// @param q  measured configuration (n_q)
/// @returns postures (n_a each) [rad, m]; empty if an object would be dropped, nothing is touched, or joint limits block every way
/// Tests: tests/execution/step_back_test.cpp
std::vector<Eigen::VectorXd> find_step_back(const world::Model& model, Eigen::VectorXd q);

/// True if a robot touches an object, or nearly does. @param q  measured configuration (n_q)
bool touches_objects(const world::Model& model, const Eigen::VectorXd& q);

}  // namespace stiction::execution
