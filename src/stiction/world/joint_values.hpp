#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Number of joints that move, followers included.
int number_of_joints(std::span<const Link> links);

/// Extracts the values of the joints that move by themselves (n_a). The list has one value for each of these joints, or one for each joint that
/// moves, in the order of the links. nullopt for a list of any other length.
/// @param n_vu  number of velocity coordinates of the objects, which precede those of the joints
std::optional<Eigen::VectorXd> own_joint_values(std::span<const Link> links, int n_vu, int n_a,
                                                const Eigen::Ref<const Eigen::VectorXd>& values);

}  // namespace stiction::world
