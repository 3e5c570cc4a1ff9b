#pragma once

#include <Eigen/Core>

#include "stiction/contact/contact.hpp"

// Internal to the layer: lowest points of rims under the barrier. docs/theory/patches.md, (S.17).

namespace stiction::dynamics::detail {

/// A contact with less than this share of σ has no row, unless the solution violates its row.
inline constexpr double kLeastShare = 1e-4;

/// Share of σ of a contact in a smoothed step. It is below 1 for the lowest point of a rim whose cap lies nearly flat on the touched
/// surface.
double barrier_share(const world::Model& model, const world::Kinematics& kinematics, const contact::Contact& contact);

/// Derivative of ln(barrier_share) by q (n_v). @returns false if it is 0
bool calc_share_slope(const world::Model& model, const world::Kinematics& kinematics, const contact::Contact& contact,
                      Eigen::VectorXd& slope);

}  // namespace stiction::dynamics::detail
