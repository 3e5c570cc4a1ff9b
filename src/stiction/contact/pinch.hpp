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

/// From the posture in q: the trunk takes the hand to the object, and the hand closes. Where the two parts are not opposite each other, the hand is turned to
/// the normal that was found, and closes again.
/// @param q  configuration (n_q); changed in place
/// @returns whether both parts touch, and the line between their middles is within half of the friction at both
bool close_pinch(const world::Model& model, const world::RobotChains& chains, Pinch pinch, int trunk, core::Random& random,
                 Eigen::VectorXd& q, GeometryWorkspace& work);

}  // namespace stiction::contact
