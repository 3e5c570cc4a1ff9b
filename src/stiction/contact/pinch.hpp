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
  world::ChainMask moved = 0;  ///< branches that move: the trunk that carries both jaws, and the branches that close them
};

/// Draws two parts of the gripper that `trunk` carries such that both can touch the same geometry of an object. A hand with more than two
/// fingers does not count as a gripper: it has other ways to hold an object, and pinches make its searches longer.
/// @param draw  branches that may move  @param touch  per pair of the model: 1 if it may be brought into contact; empty: any pair
/// @returns nullopt if the trunk carries no gripper; then no random number is used
std::optional<Pinch> draw_pinch(const world::Model& model, const world::RobotChains& chains, int trunk, world::ChainMask draw,
                                std::span<const char> touch, core::Random& random, std::vector<int>& scratch);

/// Closes a pinch from the posture in q: the trunk takes the hand to the object, and the hand closes without touching its surroundings. If
/// the two contacts do not face each other, the hand turns to the contact normal that was found and closes again.
/// @param q  configuration (n_q); changed in place
/// @returns whether both parts touch the object, and the line between their middles uses at most 0.3 of the friction at both contacts; the
///   remaining friction can carry the weight
bool close_pinch(const world::Model& model, const world::RobotChains& chains, Pinch pinch, int trunk, core::Random& random,
                 Eigen::VectorXd& q, GeometryWorkspace& work);

/// Computes commands with which the jaws hold a free object against gravity by friction while the robot stays in the posture of q. The two
/// contact forces are opposite and act along the line between the middles of the parts, so the trunk carries no load from them:
///
///     K (u − qᵃ) = (J_a − J_b)ᵀ f ,   m g/(2 μ) ≤ ‖f‖ ≤ 5 m g                                                                           (R.1)
///
/// ‖f‖ is as large as the command limits, the joint efforts and fragile bodies allow, and at most the preload of a push (P.11).
/// @param work  its kinematics are those of q
/// @returns u (n_a), which equals qᵃ for objects on joints; nullopt if the jaws cannot hold the object
std::optional<Eigen::VectorXd> hold_pinch(const world::Model& model, const Pinch& pinch, const Eigen::VectorXd& q,
                                          const GeometryWorkspace& work);

}  // namespace stiction::contact
