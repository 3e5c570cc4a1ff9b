#pragma once

#include <Eigen/Core>
#include <optional>

#include "stiction/planning/contact_sampler.hpp"

namespace stiction::planning {

/// A small motion of one branch along an object that it touches.
struct Slide {
  int branch;
  Eigen::VectorXd delta;  ///< of the joints, ‖δ‖ = 1; 0 for those of other branches (n_a)
};

/// A gap that counts as touching [m].
constexpr double kSlideReach = 3e-3;

/// Draws a contact of a branch with an object and a direction t of its tangent plane, and moves the branch there so that to first order none of
/// its gaps below kSlideReach opens or closes,
///     δ ∝ argmin ‖δ‖²  subject to  ∇φᵀδ = 0,  t·(v_A − v_B) = 1                                       (P.8)
/// @returns nullopt where no branch touches an object, or the drawn one cannot move like that
std::optional<Slide> draw_slide(const world::Model& model, const RobotChains& chains, const Eigen::VectorXd& q, core::Random& random,
                                GeometryWorkspace& work);

}  // namespace stiction::planning
