#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/contact/contact.hpp"

namespace stiction::contact {

/// One flag per robot joint (n_a): 1 for the given joints, else 0.
std::vector<char> joint_flags(const world::Model& model, std::span<const int> joints);

/// Computes dφ/dqᵃ of one contact (n_a), with 0 for joints that are not `moving`. Use it instead of calc_jacobian() if only row n is
/// needed.
/// @param kinematics  kinematics at the configuration of the contact
void calc_gap_gradient(const world::Model& model, const Contact& contact, const std::vector<char>& moving,
                       const world::Kinematics& kinematics, Eigen::Ref<Eigen::VectorXd> gradient);

}  // namespace stiction::contact
