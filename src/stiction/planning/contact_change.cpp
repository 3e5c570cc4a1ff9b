#include "stiction/planning/contact_change.hpp"

#include <algorithm>
#include <limits>

namespace stiction::planning {
void ContactChange::choose(const Tree& tree, Expansion& x, core::Random& random) const {
  if (tree[x.near].edge == SegmentKind::Regrasp) x.near = tree[x.near].parent;
  const Node& near = tree[x.near];
  // If the release of some branches leaves the object unstable, so does the release of these and other branches together.
  const auto unstable = [&](world::ChainMask moved) { return (moved & x.release.moved) == moved; };
  for (int k = 0; k < threshold::kBranchDraws; ++k) {
    x.release = {contact::draw_grasp(setting_.chains, contact::GenericSampler{}, random), x.may_be_unstable};
    if (x.may_be_unstable || std::ranges::none_of(near.unstable_releases, unstable)) return;
  }
  x.release.may_be_unstable = true;  // last resort: all draws would be unstable
}

bool ContactChange::try_edge(const Tree& tree, Expansion& x, core::Random& random, ThreadScratch& scratch, Node& node) const {
  const Node& near = tree[x.near];
  Regrasp& regrasp = scratch.regrasp;
  const GraspJudge judge{[&](const auto& q, const auto& u) { return predict(q, u, x, scratch); },
                         [&](const auto& q, const auto& u, const auto& command) { return simulated_distance(q, u, command, x, scratch); },
                         {.touch = x.touch},
                         x.choose};
  const bool held = try_regrasp(setting_, near.q, near.u, x.release, judge, random, scratch, regrasp, x.totals.regrasps);
  static_cast<Work&>(x.totals) += regrasp;
  x.release_unstable = regrasp.unstable && !x.release.may_be_unstable;
  node.unstable = regrasp.unstable;
  node.edge = SegmentKind::Regrasp;
  if (held) set_edge(regrasp.knots, setting_.model, node);
  return held;
}

Promise ContactChange::predict(const Eigen::VectorXd& q, const Eigen::VectorXd& u, Expansion& x, ThreadScratch& scratch) const {
  const ProfileClock::Scope scope(scratch.profile, Activity::GraspModels);
  Node& node = scratch.candidate;
  node.q = q;
  node.u = u;
  if (!models_.linearise(node, x.in_cones, scratch, x.totals)) return {std::numeric_limits<double>::infinity(), node.u};
  const Eigen::VectorXd u_from = models_.preloaded_command(node);
  Eigen::VectorXd e = setting_.goal.difference(node.local.c_u, x.target(setting_.goal, node.local.c_u));
  const Eigen::VectorXd delta_u =
      extend_.extension(node.local, u_from, e, x.counted, x.in_cones ? &scratch.step_result : nullptr, scratch.least_squares);
  e -= node.local.B_u * delta_u;
  e = e.cwiseProduct(x.counted).eval();
  return {setting_.goal.inverse_tolerances().cwiseProduct(e).norm(),
          (u_from + delta_u).cwiseMax(setting_.model.command_lower()).cwiseMin(setting_.model.command_upper())};
}

double ContactChange::simulated_distance(const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Eigen::VectorXd& command,
                                         const Expansion& x, ThreadScratch& scratch) const {
  const ProfileClock::Scope scope(scratch.profile, Activity::GraspTrials);
  Node from, to;
  from.q = q;
  from.u = u;
  Totals totals;
  const bool moved = extend_.push(from, command, scratch, totals, to);
  scratch.regrasp += totals;
  scratch.steps.forget();  // the regrasp continues from another state
  return x.distance(setting_.goal, moved ? to.q : q);
}

}  // namespace stiction::planning
