#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/simulation/push.hpp"
#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Place of a hand at one time. The hand rests in each knot and moves at s²(3 − 2s) between them.
struct HandKnot {
  double time = 0;                                ///< [s]
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();  ///< point of the link on which it presses, in the link's frame [m]
  double depth = 0;                               ///< depth of the hand beyond the place of this point at the start [m]
};

/// A hand that presses on a link through a spring and moves along it, as a person's hand does. Its motion is given, and the arm has to yield.
struct HandPush {
  int body = -1;                                           ///< link; −1: no hand
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();  ///< direction in which it presses, unit
  double stiffness = 0;                                    ///< stiffness of the spring [N/m], > 0
  std::vector<HandKnot> knots;                             ///< places of the hand, the first at time 0
};

/// Place of the hand at a time, interpolated between knots and held after the last one.
HandKnot calc_hand(const HandPush& hand, double time);

/// Force of the hand on the link, k ⟨depth − u·(p − p_start)⟩₊ u: the spring is compressed by the part of the depth to which the point has not yielded along
/// u. There is no friction.
/// @param start, now  poses of the link at the start, and now
simulation::Push calc_push(const HandPush& hand, const world::Pose& start, const world::Pose& now, double time);

}  // namespace stiction::execution
