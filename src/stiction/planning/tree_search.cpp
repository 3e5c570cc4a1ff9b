#include "stiction/planning/tree_search.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "stiction/planning/contact_limits.hpp"
#include "stiction/planning/settle_start.hpp"

namespace stiction::planning {

namespace {

/// Indices of the coordinates whose flag is not 0.
std::vector<int> flagged(const Eigen::VectorXd& flags) {
  std::vector<int> out;
  for (Eigen::Index v = 0; v < flags.size(); ++v) {
    if (flags[v] != 0) out.push_back(static_cast<int>(v));
  }
  return out;
}

}  // namespace

TreeSearch::TreeSearch(const Setting& setting, const Eigen::VectorXd& u_start, std::uint64_t seed, double bound)
    : setting_(setting),
      u_start_(u_start),
      seed_(seed),
      bound_(bound),
      models_(setting_),
      extend_(setting_, models_),
      contact_change_(setting_, models_, extend_),
      verifier_(setting_, seed),
      tools_(setting_),
      writer_(setting_),
      tree_(setting_.goal.space(), setting_.goal.inverse_tolerances().cwiseAbs2(),
            tools_.any() ? flagged(setting_.goal.flags(setting_.goal.objects())) : std::vector<int>{}),
      least_distance_(std::numeric_limits<double>::infinity()) {}

bool TreeSearch::plant_root(ThreadScratch& scratch, PlanResult& result) {
  const auto settled = settle_start(setting_, u_start_, scratch, totals_, result);
  if (!settled) return false;
  Node root;
  root.edge = SegmentKind::Settle;
  set_edge(settled->knots, setting_.model, root);
  root.q = settled->q;
  root.u = settled->u;
  if (!models_.linearise(root, false, scratch, totals_)) {
    result.reason = "the start has no local model: its smoothed step is not solved";
    return false;
  }
  if (!verifier_.verify_root(root, scratch, totals_, root.replay)) {
    if (!scratch.stop()) result.reason = "the start cannot be settled: a step of half the length is not solved";
    return false;
  }
  insert(std::move(root), false);
  return true;
}

Expansion TreeSearch::draw() {
  Expansion x;
  x.stream = static_cast<std::uint64_t>(++drawn_);
  core::Random random(seed_, x.stream << 1);
  x.grasp = random.chance(threshold::kGraspProbability);
  x.in_cones = setting_.options.uses(Mechanism::ForceCones) && random.chance(threshold::kInCones);
  x.may_be_unstable = totals_.regrasps.unstable > threshold::kStableReleases * std::max(1L, totals_.regrasps.accepted);
  x.subgoal = setting_.goal.q_goal();
  x.choose = !random.chance(waiting() * waiting());  // if the most promising grasps lead nowhere, others must be tried
  x.to_goal = random.chance(setting_.options.goal_bias);
  if (!x.to_goal) {
    setting_.goal.space().sample(setting_.options.sample_boxes, random, x.subgoal);
    x.tool = tools_.draw(random);
  }
  if (!setting_.options.uses(Mechanism::Frontier)) return x;
  const bool by_place = random.chance(x.to_goal ? threshold::kByPlaceToGoal : threshold::kByPlace);
  if (by_place && x.grasp && !x.to_goal && random.chance(waiting())) {
    x.at_place = true;
  } else if (by_place || (x.grasp && x.to_goal)) {
    x.near = tree_.take_by_place(x.grasp);
  } else if (x.to_goal) {
    x.near = tree_.take_by_metric();
  }
  return x;
}

void TreeSearch::expand(Expansion& x, ThreadScratch& scratch) const {
  if (scratch.stop()) return;
  const ProfileClock::Scope scope(scratch.profile, Activity::Selection);
  core::Random random(seed_, (x.stream << 1) + 1);
  aim(x, random, scratch);
  if (tree_[x.near].replay.empty()) {
    x.refined = x.near;
    const Node& node = tree_[x.near];
    const Node& parent = tree_[node.parent];
    x.rejected = !verifier_.verify_edge(parent, parent.replay, node, scratch, x.totals, x.near_replay);
    if (x.rejected) return;
  }
  if (x.grasp) contact_change_.choose(tree_, x, random);
  const Node& near = tree_[x.near];
  Node node;
  node.parent = x.near;
  const bool grown =
      x.grasp ? contact_change_.try_edge(tree_, x, random, scratch, node) : extend_.try_edge(near, x, scratch, x.command, node);
  if (!grown || !complete(near, scratch, x.totals, node)) return;
  x.chain.push_back(std::move(node));
  const EdgeReplay& near_replay = near.replay.empty() ? x.near_replay : near.replay;
  while (setting_.options.uses(Mechanism::Chains) && goes_on(x, near) && lengthen(x, near, near_replay, scratch)) {
  }
}

int TreeSearch::find_near(const Expansion& x) const {
  const std::vector<int> v = x.aim.empty() ? std::vector<int>{} : flagged(x.counted);
  const int near = x.at_place ? tree_.nearest_place(x.subgoal, v) : -1;
  return near >= 0 ? near : tree_.nearest(x.subgoal, v);  // (3.8)
}

void TreeSearch::aim(Expansion& x, core::Random& random, ThreadScratch& scratch) const {
  const GoalMeasure& goal = setting_.goal;
  x.counted = x.to_goal ? goal.bounded() : Eigen::VectorXd::Ones(setting_.model.n_vu());
  if (!tools_.any()) {
    if (x.near < 0) x.near = find_near(x);
    return;
  }
  const auto aim_at = [&](std::vector<int> objects) {
    x.aim = std::move(objects);
    if (!x.to_goal) x.counted = goal.flags(x.aim);
  };
  aim_at(goal.objects());
  if (x.near < 0 && x.tool < 0) x.near = find_near(x);
  if (x.tool < 0) {
    x.touch = tools_.touchable(x.aim, tree_[x.near].q, scratch.geometry);
    if (!x.touch.empty()) return;
    x.to_goal = false;  // no object is near enough to move them: a tool must come first
    while (x.tool < 0) x.tool = tools_.draw(random);
  }
  const Eigen::VectorXd& q = tree_[x.near >= 0 ? x.near : tree_.best()].q;
  x.subgoal = q.head(setting_.model.n_qu());
  tools_.draw_place(x.tool, q, random, scratch.geometry, x.subgoal);
  aim_at({x.tool});
  if (x.near < 0) x.near = find_near(x);
  x.touch = tools_.touchable(x.aim, tree_[x.near].q, scratch.geometry);
  x.grasp = x.grasp && !x.touch.empty();
}

int TreeSearch::insert(Expansion& x, ThreadScratch& scratch) {
  const ProfileClock::Scope scope(scratch.profile, Activity::Selection);
  ++iterations_;
  totals_ += x.totals;
  if (x.totals.regrasps.tried > x.totals.regrasps.accepted) refused_[x.near] += x.totals.regrasps;
  if (x.refined >= 0 && !scratch.stop()) record_verdict(x);  // a run that was stopped may not have finished the verification
  if (x.release_unstable) tree_.add_unstable_release(x.near, x.release.moved);
  totals_.distrusted += x.broken;
  if (x.command.size() > 0) tree_.add_tried(x.near, std::move(x.command));
  int parent = x.near;
  for (std::size_t k = 0; k < x.chain.size() && !tree_.pruned(parent); ++k) {
    x.chain[k].parent = parent;
    parent = insert(std::move(x.chain[k]), k + 1 < x.chain.size());
    if (reaches_goal(parent, scratch)) return parent;
  }
  return -1;
}

void TreeSearch::add_refused(std::vector<RefusedMoves>& out) const {
  for (const auto& [node, counts] : refused_) out.push_back({tree_[node].q, counts});
}

bool TreeSearch::stalled() const { return setting_.options.uses(Mechanism::Restarts) && waiting() > 1; }

double TreeSearch::waiting() const {
  return static_cast<double>(iterations_ - last_gain_) / static_cast<double>(std::max(threshold::kLeastStall, iterations_ / 2));
}

Plan TreeSearch::plan_to(int node, bool forces, ThreadScratch& scratch) {
  return writer_.to_plan(tree_, tree_.path_to(node), forces, scratch, totals_);
}

bool TreeSearch::complete(const Node& parent, ThreadScratch& scratch, Totals& totals, Node& node) const {
  const ProfileClock::Scope scope(scratch.profile, Activity::LocalModels);
  node.pushes = parent.pushes + starts_push(parent, node);
  node.cost = cost_to(setting_.model, parent, node);
  return node.cost < bound_ && models_.linearise(node, false, scratch, totals);
}

bool TreeSearch::goes_on(const Expansion& x, const Node& near) const {
  const auto& chain = x.chain;
  if (chain.size() >= threshold::kLongestChain) return false;
  const Node& last = chain.back();
  if (last.edge == SegmentKind::Regrasp) return true;
  const Node& before = chain.size() > 1 ? chain[chain.size() - 2] : near;
  const double distance = x.distance(setting_.goal, last.q);
  if (x.to_goal && distance <= setting_.options.tolerance_fraction)
    return true;  // lengthen() checks whether the state at half sub-steps is there as well
  return distance > setting_.options.tolerance_fraction && distance < threshold::kProgress * x.distance(setting_.goal, before.q);
}

bool TreeSearch::lengthen(Expansion& x, const Node& near, const EdgeReplay& near_replay, ThreadScratch& scratch) const {
  auto& chain = x.chain;
  const bool first = chain.size() == 1;
  const Node& before = first ? near : chain[chain.size() - 2];
  Node& last = chain.back();
  if (!verifier_.verify_edge(before, first ? near_replay : before.replay, last, scratch, x.totals, last.replay)) {
    ++x.broken;
    chain.pop_back();
    return false;
  }
  const double fraction = setting_.options.tolerance_fraction;
  if (x.to_goal && setting_.goal.ratio(last.q) <= fraction) {
    // Both resolutions are at the goal, or they are too far apart for one more push to bring both there.
    if (setting_.goal.ratio(last.replay.q_fine) <= fraction) return false;
    if (setting_.goal.share_of_tolerances(last.q, last.replay.q_fine) > 2 * fraction) return false;
  }
  Node next;
  Eigen::VectorXd command;
  const bool extended = extend_.try_edge(last, x, scratch, command, next) && complete(last, scratch, x.totals, next);
  if (command.size() > 0) last.tried.push_back(std::move(command));
  if (extended) chain.push_back(std::move(next));
  return extended;
}

void TreeSearch::record_verdict(Expansion& x) {
  if (!tree_[x.refined].replay.empty()) return;  // another expansion of the round verified the node, with the same outcome
  set_replay(x.refined, std::move(x.near_replay));
  if (!x.rejected) return;
  tree_.prune(x.refined);
  ++totals_.distrusted;
}

int TreeSearch::insert(Node node, bool visited) {
  std::tie(node.goal_ratio, node.goal_distance) = how_far(node.q, node.replay);
  if (node.goal_distance < threshold::kGain * least_distance_) {
    least_distance_ = node.goal_distance;
    last_gain_ = iterations_;
  }
  const Eigen::VectorXd goal = setting_.goal.nearest_to(node.local.c_u);
  return tree_.add(std::move(node), goal, visited);
}

std::pair<double, double> TreeSearch::how_far(const Eigen::VectorXd& q, const EdgeReplay& replay) const {
  const double ratio = setting_.goal.ratio(q), distance = setting_.goal.distance(q);
  if (replay.empty()) return {ratio, distance};
  return {std::max(ratio, setting_.goal.ratio(replay.q_fine)), std::max(distance, setting_.goal.distance(replay.q_fine))};
}

void TreeSearch::set_replay(int i, EdgeReplay replay) {
  const auto [ratio, distance] = how_far(tree_[i].q, replay);
  tree_.set_replay(i, std::move(replay), ratio, distance);
}

bool TreeSearch::reaches_goal(int node, ThreadScratch& scratch) {
  if (tree_[node].edge == SegmentKind::Regrasp || setting_.goal.ratio(tree_[node].q) > setting_.options.tolerance_fraction) return false;
  EdgeReplay replay = tree_[node].replay;
  bool holds = true;
  if (replay.empty() && tree_[node].parent >= 0) {
    const Node& parent = tree_[tree_[node].parent];
    holds = verifier_.verify_edge(parent, parent.replay, tree_[node], scratch, totals_, replay);
  }
  if (holds && setting_.goal.ratio(replay.q_fine) > setting_.options.tolerance_fraction) {
    set_replay(node, std::move(replay));
    return false;
  }
  for (const auto& q : replay.disturbed.colwise()) holds = holds && setting_.goal.ratio(q) <= 1;
  if (holds) {
    set_replay(node, std::move(replay));
  } else if (!scratch.stop()) {
    tree_.prune(node);
    ++totals_.distrusted;
  }
  return holds;
}

}  // namespace stiction::planning
