#pragma once

#include <Eigen/Core>

#include "stiction/contact/contact.hpp"

// Internal to the layer: lowest points of rims under the barrier. docs/theory/patches.md, (S.17).

namespace stiction::dynamics::detail {

/// Contacts with less than this share of σ have no row, unless it is violated.
inline constexpr double kLeastShare = 1e-4;

/// Share of σ that a contact of a smoothed step has: less than 1 for the lowest point of a rim whose cap lies nearly flat on what it touches.
double barrier_share(const world::Model& model, const world::Kinematics& kinematics, const contact::Contact& contact);

/// Derivative of its logarithm by q (n_v). @returns false where it is 0
bool calc_share_slope(const world::Model& model, const world::Kinematics& kinematics, const contact::Contact& contact,
                      Eigen::VectorXd& slope);

}  // namespace stiction::dynamics::detail
