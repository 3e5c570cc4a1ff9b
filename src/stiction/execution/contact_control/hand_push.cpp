#include "stiction/execution/contact_control/hand_push.hpp"

#include <algorithm>

namespace stiction::execution {

HandKnot calc_hand(const HandPush& hand, double time) {
  std::size_t k = 0;
  while (k + 1 < hand.knots.size() && time >= hand.knots[k + 1].time) ++k;
  const HandKnot& from = hand.knots[k];
  if (k + 1 == hand.knots.size()) return {time, from.p_L, from.depth};
  const HandKnot& to = hand.knots[k + 1];
  const double s = std::clamp((time - from.time) / (to.time - from.time), 0.0, 1.0), share = s * s * (3 - 2 * s);
  return {time, from.p_L + share * (to.p_L - from.p_L), from.depth + share * (to.depth - from.depth)};
}

simulation::Push calc_push(const HandPush& hand, const world::Pose& start, const world::Pose& now, double time) {
  const HandKnot at = calc_hand(hand, time);
  const double yielded = hand.direction_W.dot(now * at.p_L - start * at.p_L);
  return {.body = hand.body, .p_BP = at.p_L, .force_W = hand.stiffness * std::max(0.0, at.depth - yielded) * hand.direction_W};
}

}  // namespace stiction::execution
