#include "stiction/planning/contact_change.hpp"

#include <algorithm>
#include <limits>

namespace stiction::planning {
namespace {

/// Draws of the branches of a regrasp, until some may be able to let go of the object.
constexpr int kDraws = 30;
/// Extensions of a tree after which a loose regrasp is as good as any: of a ball in an open hand no other may lead to the goal.
constexpr std::uint64_t kHeldExtensions = 1000;

}  // namespace

void ContactChange::choose(const Tree& tree, Expansion& x, core::Random& random) const {
  if (tree[x.near].edge == SegmentKind::Regrasp) x.near = tree[x.near].parent;
  const Node& near = tree[x.near];
  x.grasp = false;
  if (near.cannot_release) return;
  const auto failed = [&](world::ChainMask moved) { return moved == x.release.moved; };
  // Where some leave it loose, these and others do.
  const auto loose = [&](world::ChainMask moved) { return (moved & x.release.moved) == moved; };
  for (int k = 0; k < kDraws && !x.grasp; ++k) {
    x.release = {contact::draw_grasp(setting_.chains, setting_.options.sampler, random), x.stream >= kHeldExtensions};
    x.grasp = std::ranges::none_of(near.failed_releases, failed) && (x.release.loose || std::ranges::none_of(near.loose_releases, loose));
  }
  if (!x.grasp && !near.loose_releases.empty()) {  // the last resort
    x.release = {near.loose_releases[static_cast<std::size_t>(random.index(static_cast<int>(near.loose_releases.size())))], true};
    x.grasp = true;
  }
  if (!x.grasp) x.cannot_release = x.near;
}

bool ContactChange::try_edge(const Tree& tree, Expansion& x, core::Random& random, ThreadScratch& scratch, Node& node) const {
  const Node& near = tree[x.near];
  if (!setting_.options.real_regrasps) {
    ++x.totals.regrasps.tried;
    const auto sample = contact::sample_contact(setting_.model, setting_.chains, setting_.options.sampler, x.release.moved, near.q, random,
                                                scratch.geometry);
    if (!sample) {
      ++x.totals.regrasps.no_sample;
      return false;
    }
    ++x.totals.regrasps.accepted;
    node.q = near.q;
    node.q.tail(setting_.model.n_a()) = sample->q_a;
    node.u = sample->q_a;
    node.commands = sample->q_a;
    node.states = node.q;
  } else {
    const GraspJudge judge{[&](const auto& q) { return predict(q, x, scratch); },
                           [&](const auto& q, const auto& command) { return simulated_distance(q, command, x, scratch); }};
    const bool held = try_regrasp(setting_, near.q, near.u, x.release, judge, random, scratch, scratch.regrasp, x.totals.regrasps);
    static_cast<Work&>(x.totals) += scratch.regrasp;
    x.release_failed = scratch.regrasp.stuck;
    x.release_loose = scratch.regrasp.loose && !x.release.loose;
    node.loose = scratch.regrasp.loose;
    if (!held) return false;
    node.q = scratch.regrasp.knots.back().q;
    node.u = scratch.regrasp.knots.back().u;
    set_edge(scratch.regrasp.knots, setting_.model, node);
  }
  node.edge = SegmentKind::Regrasp;
  return true;
}

Promise ContactChange::predict(const Eigen::VectorXd& q, Expansion& x, ThreadScratch& scratch) const {
  Node& node = scratch.candidate;
  node.q = q;
  node.u = q.tail(setting_.model.n_a());
  const bool solved =
      x.in_cones ? models_.linearise_with_forces(node, scratch, x.totals) : models_.linearise(node, x.stream, scratch, x.totals);
  if (!solved) return {std::numeric_limits<double>::infinity(), node.u};
  const Eigen::VectorXd q_a = q.tail(setting_.model.n_a());
  Eigen::VectorXd e = setting_.goal.difference(node.local.c_u, x.target(setting_.goal, node.local.c_u));
  const Eigen::VectorXd delta_u =
      extend_.extension(node.local, q_a, e, x.to_goal, x.in_cones ? &scratch.step_result : nullptr, scratch.least_squares);
  e -= node.local.B_u * delta_u;
  if (x.to_goal) e = e.cwiseProduct(setting_.goal.bounded()).eval();
  return {setting_.goal.inverse_tolerances().cwiseProduct(e).norm(),
          (q_a + delta_u).cwiseMax(setting_.model.lower()).cwiseMin(setting_.model.upper())};
}

double ContactChange::simulated_distance(const Eigen::VectorXd& q, const Eigen::VectorXd& command, const Expansion& x,
                                         ThreadScratch& scratch) const {
  Node from, to;
  from.q = q;
  from.u = q.tail(setting_.model.n_a());
  Totals totals;
  const bool moved = simulator_.move(from, command, scratch, totals, to);
  scratch.regrasp += totals;
  scratch.steps.forget();  // the regrasp goes on from elsewhere
  return x.distance(setting_.goal, moved ? to.q : q);
}

}  // namespace stiction::planning
