#include "stiction/planning/contact_change.hpp"

#include <algorithm>
#include <limits>

namespace stiction::planning {
namespace {

/// Draws of the branches of a regrasp, until some may be able to let go of the object.
constexpr int kDraws = 30;

}  // namespace

ContactChange::ContactChange(const world::Model& model, const PlannerOptions& options, const world::RobotChains& chains,
                             const GoalMeasure& goal, const NodeModels& models, const EdgeSimulator& simulator, const Extend& extend)
    : model_(model), options_(options), chains_(chains), goal_(goal), models_(models), simulator_(simulator), extend_(extend) {}

void ContactChange::choose(const Tree& tree, Expansion& x, core::Random& random) const {
  if (tree[x.near].edge == SegmentKind::Regrasp) x.near = tree[x.near].parent;
  const Node& near = tree[x.near];
  x.grasp = false;
  if (near.cannot_release) return;
  for (int k = 0; k < kDraws && !x.grasp; ++k) {
    x.draw = contact::draw_grasp(chains_, options_.sampler, random);
    x.grasp = std::find(near.failed_releases.begin(), near.failed_releases.end(), x.draw) == near.failed_releases.end();
  }
  if (!x.grasp) x.cannot_release = x.near;
}

bool ContactChange::try_edge(const Tree& tree, Expansion& x, core::Random& random, ThreadScratch& scratch, Node& node) const {
  const Node& near = tree[x.near];
  if (!options_.real_regrasps) {
    ++x.totals.regrasps.tried;
    const auto sample = contact::sample_contact(model_, chains_, options_.sampler, x.draw, near.q, random, scratch.geometry);
    if (!sample) {
      ++x.totals.regrasps.no_sample;
      return false;
    }
    ++x.totals.regrasps.accepted;
    node.q = near.q;
    node.q.tail(model_.n_a()) = sample->q_a;
    node.u = sample->q_a;
    node.commands = sample->q_a;
    node.states = node.q;
  } else {
    const GraspJudge judge{[&](const auto& q) { return predict(q, x, scratch); },
                           [&](const auto& q, const auto& command) { return simulated_distance(q, command, x, scratch); }};
    const bool held = try_regrasp(model_, chains_, options_, near.q, near.u, x.draw, judge, random, scratch.geometry, scratch.steps,
                                  scratch.regrasp, x.totals.regrasps);
    x.totals.steps += scratch.regrasp.steps;
    x.totals.failed_steps += scratch.regrasp.failed_steps;
    x.release_failed = scratch.regrasp.stuck;
    if (!held) return false;
    node.q = scratch.regrasp.knots.back().q;
    node.u = scratch.regrasp.knots.back().u;
    set_edge(scratch.regrasp.knots, model_, node);
  }
  node.edge = SegmentKind::Regrasp;
  return true;
}

Promise ContactChange::predict(const Eigen::VectorXd& q, Expansion& x, ThreadScratch& scratch) const {
  Node& node = scratch.candidate;
  node.q = q;
  node.u = q.tail(model_.n_a());
  const bool solved =
      x.in_cones ? models_.linearise_with_forces(node, scratch, x.totals) : models_.linearise(node, x.stream, scratch, x.totals);
  if (!solved) return {std::numeric_limits<double>::infinity(), node.u};
  const Eigen::VectorXd q_a = q.tail(model_.n_a());
  Eigen::VectorXd e(model_.n_vu());
  goal_.space().error(node.local.c_u.data(), x.target(goal_, node.local.c_u).data(), e.data());
  const Eigen::VectorXd delta_u =
      extend_.extension(node.local, q_a, e, x.to_goal, x.in_cones ? &scratch.step_result : nullptr, scratch.least_squares);
  e -= node.local.B_u * delta_u;
  if (x.to_goal) e = e.cwiseProduct(goal_.bounded()).eval();
  return {goal_.inverse_tolerances().cwiseProduct(e).norm(), (q_a + delta_u).cwiseMax(model_.lower()).cwiseMin(model_.upper())};
}

double ContactChange::simulated_distance(const Eigen::VectorXd& q, const Eigen::VectorXd& command, const Expansion& x,
                                         ThreadScratch& scratch) const {
  Node from, to;
  from.q = q;
  from.u = q.tail(model_.n_a());
  Totals totals;
  const bool moved = simulator_.move(from, command, scratch, totals, to);
  scratch.regrasp.steps += totals.steps;
  scratch.regrasp.failed_steps += totals.failed_steps;
  scratch.steps.forget();  // the regrasp goes on from elsewhere
  return x.distance(goal_, moved ? to.q : q);
}

}  // namespace stiction::planning
