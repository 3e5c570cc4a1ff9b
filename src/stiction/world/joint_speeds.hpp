#pragma once

#include "stiction/world/model.hpp"

namespace stiction::world {

/// How fast the joints of the robots may be, as `velocity` in the limits of their URDF says (n_a) [rad/s or m/s], > 0; infinite where no file says so, or
/// says 0. MJCF never does.
/// @throws core::InvalidInput "FILE:LINE: joint 'NAME' velocity: got …, expected …"
/// Tests: tests/world/joint_speeds_test.cpp
Eigen::VectorXd read_joint_speeds(const Model& model);

}  // namespace stiction::world
