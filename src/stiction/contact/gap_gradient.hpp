#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/contact/contact.hpp"

namespace stiction::contact {

/// One flag per joint (n_a).
std::vector<char> joint_flags(const world::Model& model, std::span<const int> joints);

/// dφ/dqᵃ of one contact, 0 for joints that are not `moving` (n_a): the first row of calc_jacobian(), where that alone is asked for.
/// @param kinematics  those of the contact
void calc_gap_gradient(const world::Model& model, const Contact& contact, const std::vector<char>& moving,
                       const world::Kinematics& kinematics, Eigen::Ref<Eigen::VectorXd> gradient);

}  // namespace stiction::contact
