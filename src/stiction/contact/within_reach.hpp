#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::contact {

/// Some posture of the moving joints, within their limits, may bring the two geometries of a pair together. Decided by a ball around all places of a geometry's
/// centre (world/reach_ball.hpp). Never false where they can touch; often true where they cannot.
/// @param kinematics  at q (n_q)  @param moving  per joint (n_a)
/// Tests: tests/contact/free_path_test.cpp
bool may_touch(const world::Model& model, const world::Kinematics& kinematics, const Eigen::VectorXd& q, const std::vector<char>& moving,
               int pair);

}  // namespace stiction::contact
