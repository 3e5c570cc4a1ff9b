#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/simulation/push.hpp"
#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Where a hand is at a time; at rest in each, between them at s²(3 − 2s).
struct HandKnot {
  double time = 0;                                ///< [s]
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();  ///< point of the link that it presses on, in the link's frame [m]
  double depth = 0;                               ///< how far it has come into where that point is at the start [m]
};

/// A hand that presses on a link through a spring and moves along it, as a person's does: it goes where it wants to, and the arm has to yield.
struct HandPush {
  int body = -1;                                           ///< link; −1: there is none
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();  ///< in which it presses, unit
  double stiffness = 0;                                    ///< of the spring [N/m], > 0
  std::vector<HandKnot> knots;                             ///< the first at time 0
};

/// The hand at a time: knots between which it is, held after the last one.
HandKnot calc_hand(const HandPush& hand, double time);

/// Its force on the link, k ⟨depth − u·(p − p_start)⟩₊ u: what of the depth the point has not yielded, in the direction u. Without friction.
/// @param start, now  poses of the link with the arm at the start, and now
simulation::Push calc_push(const HandPush& hand, const world::Pose& start, const world::Pose& now, double time);

}  // namespace stiction::execution
