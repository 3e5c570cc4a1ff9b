#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::contact {

/// Whether the two geometries of a pair may touch in some posture of the moving joints within their limits. The test bounds all positions
/// of a geometry's centre by a ball (world/reach_ball.hpp). It is never false if they can touch, but often true if they cannot.
/// @param kinematics  kinematics at q (n_q)  @param moving  flag per joint (n_a)
/// Tests: tests/contact/free_path_test.cpp
bool may_touch(const world::Model& model, const world::Kinematics& kinematics, const Eigen::VectorXd& q, const std::vector<char>& moving,
               int pair);

}  // namespace stiction::contact
