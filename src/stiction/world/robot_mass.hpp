#pragma once

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Computes the mass matrix M(q) of the robots, armatures included (n_a × n_a) [kg m²; kg for prismatic joints].
/// Tests: tests/simulation/spring_test.cpp
Eigen::MatrixXd calc_robot_mass(const Model& model, const Kinematics& kinematics);

}  // namespace stiction::world
