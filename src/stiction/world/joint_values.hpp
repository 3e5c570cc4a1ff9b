#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Of the joints that move, those that follow others with them.
int number_of_joints(std::span<const Link> links);

/// The values of the joints that move by themselves (n_a), of a list that has one value for each of these, or one for each joint that moves
/// in the order of the links. nullopt of a list of another length.
/// @param n_vu  velocity coordinates of the objects, after which those of the joints come
std::optional<Eigen::VectorXd> own_joint_values(std::span<const Link> links, int n_vu, int n_a,
                                                const Eigen::Ref<const Eigen::VectorXd>& values);

}  // namespace stiction::world
