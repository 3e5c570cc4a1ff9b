#include "stiction/planning/tree_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "stiction/planning/contact_limits.hpp"
#include "stiction/planning/settle_start.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;

/// Contact samples that all have to fail before the robot is said to be unable to touch an object.
constexpr long kHopelessSamples = 100;
/// Extensions in a row towards one subgoal.
constexpr std::size_t kLongestChain = 12;
/// They end when one leaves the object farther from the subgoal than this share of before.
constexpr double kChainProgress = 0.95;
/// A tree is given up for a new one when the objects have come no nearer the goal, by this share, …
constexpr double kGain = 0.9;
/// … for so many extensions and half of all that it had: how long a tree takes is spread widely, and most that stall stall for good.
constexpr long kLeastStall = 1000;

/// Extensions of a round: those of all trees are `batch`.
int round_size(const PlannerOptions& options) { return options.stop_at_goal ? std::max(1, options.batch / options.trees) : options.batch; }

/// Diagonal of a global metric (n_vu), empty for the local one.
Eigen::VectorXd global_weights(const Model& model, const Metric& metric) {
  const auto* global = std::get_if<GlobalMetric>(&metric);
  if (global == nullptr) return {};
  Eigen::VectorXd weights(model.n_vu());
  for (int i = 0; i < model.n_vu(); ++i) {
    const bool revolute = model.dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute;
    weights[i] = revolute ? global->angle : global->position;
  }
  return weights;
}

}  // namespace

TreeSearch::TreeSearch(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                       const core::RunControl& control, double bound, Crew& crew, PlanResult& result)
    : bound_(bound),
      setting_(problem, options),
      u_start_(u_start),
      control_(control),
      result_(result),
      simulator_(setting_),
      models_(setting_),
      extend_(setting_, models_, simulator_),
      contact_change_(setting_, models_, simulator_, extend_),
      verifier_(setting_, simulator_),
      subgoals_(setting_),
      writer_(setting_, simulator_),
      tree_(setting_.goal.space(), global_weights(setting_.model, options.metric), setting_.goal.inverse_tolerances().cwiseAbs2()),
      crew_(crew),
      round_(static_cast<std::size_t>(round_size(options))) {}

int TreeSearch::turn(int thread) {
  result_.status = take_in(crew_.scratch[static_cast<std::size_t>(thread)]);
  counted_.push_back(counts());
  if (thread == 0) report();  // of the calling thread, where signals and callbacks are welcome
  return result_.status == Status::MaxIterations && may_go_on() ? draw_round() : 0;
}

void TreeSearch::work(int item, int thread) {
  const auto i = static_cast<std::size_t>(order_[static_cast<std::size_t>(item)]);
  if (!control_.cancelled() && !crew_.over) expand(round_[i], crew_.scratch[static_cast<std::size_t>(thread)]);
}

void TreeSearch::report() {
  if (best_ < 0) return;
  if (grown_) tell_growth();
  if (!control_.on_progress) return;
  core::Progress progress;
  progress.iteration = iterations_;
  progress.best = goal_ratio();
  progress.size = tree_.size();
  control_.on_progress(progress);  // time and share of the budget are those of the run: see place_in_run
}

void TreeSearch::tell_growth() {
  if (told_ == tree_.size()) return;
  Growth growth;
  growth.first = told_;
  growth.best = best_;
  growth.best_ratio = goal_ratio();
  growth.q.resize(setting_.model.n_q(), tree_.size() - told_);
  for (int i = told_; i < tree_.size(); ++i) {
    growth.parents.push_back(tree_[i].parent);
    growth.q.col(i - told_) = tree_[i].q;
  }
  told_ = tree_.size();
  grown_(growth);
}

void TreeSearch::finish() {
  for (int i = 0; i < tree_.size(); ++i) {
    result_.tree.push_back({tree_[i].parent, tree_[i].edge, world::object_pose(setting_.model, tree_[i].q, setting_.problem.goal.object)});
  }
  if (best_ >= 0 && result_.status != Status::Solved) keep(tree_.path_to(best_), !control_.stop(), crew_.scratch[0]);
}

Counts TreeSearch::counts_at(long cost) const {
  const auto after = std::find_if(counted_.rbegin(), counted_.rend(), [cost](const Counts& c) { return c.cost <= cost; });
  return after == counted_.rend() ? Counts{} : *after;
}

bool TreeSearch::stalled() const {
  return setting_.options.stop_at_goal && !setting_.options.thesis_edges() &&
         iterations_ - last_gain_ > std::max(kLeastStall, iterations_ / 2);
}

bool TreeSearch::plant_root(ThreadScratch& scratch) {
  const auto settled = settle_start(setting_, u_start_, simulator_, scratch, totals_, result_);
  if (!settled) return false;
  Node root;
  root.edge = SegmentKind::Settle;
  root.q = settled->q;
  root.u = settled->u;
  set_edge(settled->knots, setting_.model, root);
  if (!models_.linearise(root, 0, scratch, totals_)) {
    result_.reason = "the start has no local model: its smoothed step is not solved";
    return false;
  }
  if (!setting_.options.thesis_edges()) {
    const Eigen::MatrixXd fine = simulator_.follow_in_half_steps(setting_.problem.q_start, root.u, root.commands, false, scratch, totals_);
    if (fine.cols() < root.commands.cols()) {
      if (!control_.stop()) result_.reason = "the start cannot be settled: a step of half the length is not solved";
      return false;
    }
    root.replay.q_fine = setting_.problem.q_start;
    if (fine.cols() > 0) root.replay.q_fine = fine.rightCols(1);
    root.replay.disturbed = root.q.replicate(1, verifier_.disturbs() ? dynamics::kDisturbances : 0);
  }
  insert(std::move(root), false);
  return true;
}

Status TreeSearch::take_in(ThreadScratch& scratch) {
  if (crew_.over) return Status::MaxIterations;
  if (best_ < 0) {
    if (!plant_root(scratch)) return Status::NumericalFailure;
    if (setting_.options.stop_at_goal && reaches_goal(best_, scratch)) return Status::Solved;
  }
  const int n = std::exchange(drawn_, 0);
  iterations_ += n;
  crew_.extensions += n;
  for (int i = 0; i < n; ++i) {
    Expansion& x = round_[static_cast<std::size_t>(i)];
    totals_ += x.totals;
    if (x.refined >= 0 && !control_.stop()) record_verdict(x);  // else it may have come to nothing for want of time
    if (x.release_failed) tree_.add_failed_release(x.near, x.release.moved);
    if (x.release_loose) tree_.add_loose_release(x.near, x.release.moved);
    if (x.cannot_release >= 0) tree_.set_cannot_release(x.cannot_release);
    totals_.distrusted += x.broken;
    if (x.command.size() > 0) tree_.add_tried(x.near, std::move(x.command));
    if (insert(x, scratch)) return Status::Solved;  // Alg. 2: AddNode, GoalReached
  }
  return control_.cancelled() ? Status::Cancelled : Status::MaxIterations;
}

bool TreeSearch::may_go_on() { return iterations_ < limit_ && !crew_.over && !control_.stop() && !stalled() && !cannot_touch(); }

int TreeSearch::draw_round() {
  drawn_ = static_cast<int>(std::min<long>(std::ssize(round_), limit_ - iterations_));
  for (int i = 0; i < drawn_; ++i)  // Alg. 2: SampleSubgoal
    round_[static_cast<std::size_t>(i)] = subgoals_.draw(tree_, iterations_ + i);
  order_.resize(static_cast<std::size_t>(drawn_));
  std::iota(order_.begin(), order_.end(), 0);  // regrasps take longest, and a round as long as its last one
  std::stable_partition(order_.begin(), order_.end(), [&](int i) { return round_[static_cast<std::size_t>(i)].grasp; });
  return drawn_;
}

bool TreeSearch::cannot_touch() {
  bool any = false;
  for (int c = 0; c < setting_.chains.size(); ++c) any |= !setting_.chains.object_pairs(c).empty();
  const RegraspCounts& r = totals_.regrasps;
  const bool hopeless = r.tried >= kHopelessSamples && r.no_sample == r.tried;
  if (any && !hopeless) return false;
  result_.reason = any ? fmt::format("the robot cannot touch an object: {} draws of a posture in contact all failed", r.tried)
                       : std::string("the robot cannot touch an object: no pair of a moving link and an object is looked at");
  return true;
}

void TreeSearch::expand(Expansion& x, ThreadScratch& scratch) {
  if (scratch.stop()) return;
  if (x.near < 0 && x.by_place) x.near = tree_.nearest_for_regrasp(x.subgoal);
  if (x.near < 0) x.near = tree_.nearest(x.subgoal);  // Alg. 2: Nearest, (3.8)
  if (!setting_.options.thesis_edges() && tree_[x.near].replay.empty()) {
    x.refined = x.near;
    const Node& node = tree_[x.near];
    const Node& parent = tree_[node.parent];
    Node left;
    x.rejected = !verifier_.verify_edge(parent, parent.replay, node, scratch, x.totals, x.near_replay, &left);
    if (x.rejected) {
      x.near = node.parent;
      if (left.q.size() > 0 && complete(parent, x, scratch, left)) x.chain.push_back(std::move(left));
      return;
    }
  }
  core::Random random(setting_.options.seed, (x.stream << 1) + 1);
  if (x.grasp) contact_change_.choose(tree_, x, random);
  const Node& near = tree_[x.near];
  Node node;
  node.parent = x.near;
  const bool grown =  // Alg. 2: Extend, or a contact sample of 3.4.3
      x.grasp ? contact_change_.try_edge(tree_, x, random, scratch, node) : extend_.try_edge(near, x, scratch, x.command, node);
  if (!grown || !complete(near, x, scratch, node)) return;
  x.chain.push_back(std::move(node));
  const EdgeReplay& near_replay = near.replay.empty() ? x.near_replay : near.replay;
  while (!setting_.options.thesis_edges() && goes_on(x, near) && lengthen(x, near, near_replay, scratch)) {
  }
}

bool TreeSearch::complete(const Node& parent, Expansion& x, ThreadScratch& scratch, Node& node) {
  node.pushes = parent.pushes + starts_push(parent, node);
  node.cost = cost_to(setting_.model, setting_.options.cost, parent, node);
  return node.cost < bound_ && models_.linearise(node, x.stream, scratch, x.totals);
}

bool TreeSearch::goes_on(const Expansion& x, const Node& near) const {
  const auto& chain = x.chain;
  if (chain.size() >= kLongestChain) return false;
  const Node& last = chain.back();
  if (last.edge == SegmentKind::Regrasp) return true;
  const Node& before = chain.size() > 1 ? chain[chain.size() - 2] : near;
  const double distance = x.distance(setting_.goal, last.q);
  if (x.to_goal && distance <= setting_.options.tolerance_fraction)
    return true;  // lengthen() looks whether the finer state is there as well
  return distance > setting_.options.tolerance_fraction && distance < kChainProgress * x.distance(setting_.goal, before.q);
}

bool TreeSearch::lengthen(Expansion& x, const Node& near, const EdgeReplay& near_replay, ThreadScratch& scratch) {
  auto& chain = x.chain;
  const bool first = chain.size() == 1;
  const Node& before = first ? near : chain[chain.size() - 2];
  Node& last = chain.back();
  Node left;
  if (!verifier_.verify_edge(before, first ? near_replay : before.replay, last, scratch, x.totals, last.replay, &left)) {
    ++x.broken;
    chain.pop_back();
    if (left.q.size() > 0 && complete(first ? near : chain.back(), x, scratch, left)) chain.push_back(std::move(left));
    return false;
  }
  if (x.to_goal && setting_.goal.ratio(last.q) <= setting_.options.tolerance_fraction) {
    // It is there, or the two resolutions are too far apart for one more push to bring both there.
    if (setting_.goal.ratio(last.replay.q_fine) <= setting_.options.share_when_refined()) return false;
    if (setting_.goal.share_of_tolerances(last.q, last.replay.q_fine) >
        setting_.options.tolerance_fraction + setting_.options.share_when_refined())
      return false;
  }
  x.taken = chain.size();
  Node next;
  Eigen::VectorXd command;
  const bool extended = extend_.try_edge(last, x, scratch, command, next) && complete(last, x, scratch, next);
  if (command.size() > 0) last.tried.push_back(std::move(command));
  if (!extended) return false;
  chain.push_back(std::move(next));
  return true;
}

void TreeSearch::record_verdict(Expansion& x) {
  if (!tree_[x.refined].replay.empty()) {  // another one of the round was first, with the same outcome
    if (x.rejected) x.chain.clear();
    return;
  }
  set_replay(x.refined, std::move(x.near_replay));
  if (!x.rejected) return;
  tree_.prune(x.refined);
  ++totals_.distrusted;
}

bool TreeSearch::insert(Expansion& x, ThreadScratch& scratch) {
  int parent = x.near;
  for (std::size_t k = 0; k < x.chain.size() && !tree_.pruned(parent); ++k) {
    x.chain[k].parent = parent;
    parent = insert(std::move(x.chain[k]), x.to_goal && k < x.taken);
    if (setting_.options.stop_at_goal && reaches_goal(parent, scratch)) return true;
  }
  return false;
}

int TreeSearch::insert(Node node, bool taken) {
  std::tie(node.goal_ratio, node.goal_distance) = how_far(node.q, node.replay);
  const double ratio = node.goal_ratio;
  if (node.goal_distance < kGain * least_distance_) {
    least_distance_ = node.goal_distance;
    last_gain_ = iterations_;
  }
  if (setting_.options.record_tree)
    result_.records.push_back({node.parent, node.edge, iterations_, node.q, node.local.c_u, node.local.B_u});
  const Eigen::VectorXd goal = setting_.goal.nearest_to(node.local.c_u);
  const int i = tree_.add(std::move(node), goal, taken);
  if (best_ < 0 || ratio < tree_[best_].goal_ratio) best_ = i;
  return i;
}

std::pair<double, double> TreeSearch::how_far(const Eigen::VectorXd& q, const EdgeReplay& replay) const {
  const double ratio = setting_.goal.ratio(q), distance = setting_.goal.distance(q);
  if (replay.empty()) return {ratio, distance};
  return {std::max(ratio, setting_.goal.ratio(replay.q_fine)), std::max(distance, setting_.goal.distance(replay.q_fine))};
}

void TreeSearch::set_replay(int i, EdgeReplay replay) {
  const auto [ratio, distance] = how_far(tree_[i].q, replay);
  tree_.set_replay(i, std::move(replay), ratio, distance);
  if (i != best_) return;
  for (int k = 0; k < tree_.size(); ++k) {
    if (tree_[k].goal_ratio < tree_[best_].goal_ratio) best_ = k;
  }
}

bool TreeSearch::reaches_goal(int node, ThreadScratch& scratch) {
  if (tree_[node].edge == SegmentKind::Regrasp) return false;
  if (setting_.goal.ratio(tree_[node].q) > setting_.options.tolerance_fraction) return false;
  if (!setting_.options.thesis_edges() && !verify_at_goal(node, scratch)) return false;
  const std::vector<int> path = tree_.path_to(node);
  if (!setting_.options.thesis_edges() && !survives_noise(path, scratch)) return false;
  keep(path, true, scratch);
  return true;
}

bool TreeSearch::verify_at_goal(int node, ThreadScratch& scratch) {
  EdgeReplay replay = tree_[node].replay;
  bool holds = true;
  if (replay.empty()) {
    const Node& parent = tree_[tree_[node].parent];
    holds = verifier_.verify_edge(parent, parent.replay, tree_[node], scratch, totals_, replay);
  }
  if (holds && setting_.goal.ratio(replay.q_fine) > setting_.options.share_when_refined()) {
    set_replay(node, std::move(replay));
    return false;
  }
  for (const auto& q : replay.disturbed.colwise()) holds = holds && setting_.goal.ratio(q) <= 1;
  if (holds) {
    set_replay(node, std::move(replay));
  } else if (!control_.stop()) {
    tree_.prune(node);
    ++totals_.distrusted;
  }
  return holds;
}

bool TreeSearch::survives_noise(const std::vector<int>& path, ThreadScratch& scratch) {
  const int end = verifier_.follow_with_noise(tree_, path, scratch, totals_);
  if (end != kOnPath && !control_.stop()) totals_.distrusted += tree_.prune_subtree(end);
  return end == kOnPath;
}

void TreeSearch::keep(const std::vector<int>& path, bool forces, ThreadScratch& scratch) {
  result_.plan = writer_.to_plan(tree_, path, forces, scratch, totals_);
  result_.cost = path_cost(setting_.model, result_.plan, setting_.options.cost);
}

}  // namespace stiction::planning
