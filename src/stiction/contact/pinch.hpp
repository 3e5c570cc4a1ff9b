#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "stiction/contact/geometry_workspace.hpp"
#include "stiction/core/random.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::contact {

/// The two jaws of a gripper on opposite sides of an object, as pairs of the model.
struct Pinch {
  int pair_a = 0, pair_b = 0;
  world::ChainMask moved = 0;  ///< the trunk that carries both, and what closes
};

/// Draws two parts of a gripper that `trunk` carries and that can touch the same geometry of an object. A hand of more than two fingers
/// is none: it has other ways to hold, and searches take longer with pinches.
/// @param draw  branches that may move  @param touch  1 per pair that may be brought into contact (pairs of the model); empty: any
/// @returns nothing where the trunk carries no gripper; then no random number is used
std::optional<Pinch> draw_pinch(const world::Model& model, const world::RobotChains& chains, int trunk, world::ChainMask draw,
                                std::span<const char> touch, core::Random& random, std::vector<int>& scratch);

/// From the posture in q: the trunk takes the hand to the object, and the hand closes, clear of what is around it. Where the two parts are not opposite each other, the hand is turned to
/// the normal that was found, and closes again.
/// @param q  configuration (n_q); changed in place
/// @returns whether both parts touch, and the line between their middles is within 0.3 of the friction at both, so that most of it is left for the weight
bool close_pinch(const world::Model& model, const world::RobotChains& chains, Pinch pinch, int trunk, core::Random& random,
                 Eigen::VectorXd& q, GeometryWorkspace& work);

/// Commands with which the jaws hold a free object against gravity by friction, and the robot stays in the posture of q. The two forces are opposite, along
/// the line between the middles of the parts, so that the trunk carries none of them:
///
///     K (u − qᵃ) = (J_a − J_b)ᵀ f ,   m g/(2 μ) ≤ ‖f‖ ≤ 5 m g                                                                           (R.1)
///
/// ‖f‖ is as large as commands, efforts and what is fragile allow, and at most the preload of a push (P.11). @param work  its kinematics are those of q
/// @returns u (n_a), qᵃ for objects on joints; nothing where the jaws cannot hold the object
std::optional<Eigen::VectorXd> hold_pinch(const world::Model& model, const Pinch& pinch, const Eigen::VectorXd& q,
                                          const GeometryWorkspace& work);

}  // namespace stiction::contact
