#include "stiction/planning/planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/core/random.hpp"
#include "stiction/planning/bounded_least_squares.hpp"
#include "stiction/planning/cone_least_squares.hpp"
#include "stiction/planning/contact_sampler.hpp"
#include "stiction/planning/disturbances.hpp"
#include "stiction/planning/drag.hpp"
#include "stiction/planning/force_gap.hpp"
#include "stiction/planning/lanes.hpp"
#include "stiction/planning/object_space.hpp"
#include "stiction/planning/regrasp.hpp"
#include "stiction/planning/robot_chains.hpp"
#include "stiction/planning/tree.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;

/// Largest penetration that an edge may build up [m].
constexpr double kMaxPenetration = 5e-4;
/// Distance across which a force may act in a sub-step of half the length, and penetration there [m]; the checker allows 1 mm.
constexpr double kMaxForceGap = 0.95e-3, kMaxFinePenetration = 0.95e-3;
/// The settling of the start stops when no object moves farther than this in a step [m or rad].
constexpr double kSettled = 1e-6;
constexpr int kMaxSettleSteps = 100;
/// An object that is still moving after so many steps and has gone this far is not supported [m or rad].
constexpr double kFallen = 0.05;
/// Contact samples that all have to fail before the robot is said to be unable to touch an object.
constexpr long kHopelessSamples = 100;
/// Draws of the branches of a regrasp, until some may be able to let go of the object.
constexpr int kDraws = 30;
/// Errors of commands that a plan has to survive [rad or m].
constexpr double kNoise = 1e-6;
/// What gravity from aside is given time to move: steps for which the last command of an edge is held.
constexpr int kTiltHeld = 3;
constexpr double kRests = 1e-3;  // … or until the objects move by less in a step, in tolerances
/// No edge of a path: it got where it was to go.
constexpr int kOnPath = -1;
/// Extensions in a row towards one subgoal.
constexpr std::size_t kLongestChain = 12;
/// They end when one leaves the object farther from the subgoal than this share of before.
constexpr double kChainProgress = 0.95;
/// Contacts farther apart than this do not bound an extension by their forces: those are tiny, and their linear models of no use [m].
constexpr double kForceReach = 0.01;
/// Share of the growths whose contact forces stay in their cones.
constexpr double kInCones = 0.5;
/// Share of the regrasps towards drawn subgoals that start from the node whose object is nearest, the others from the nearest one.
constexpr double kByPlace = 0.5;
/// Share of the pushes not yet taken to the goal that start from the front of the tree (Tree::take_for_push), half of them towards the goal:
/// by the metric alone, most start from the many postures around an object that has hardly moved.
constexpr double kFromFront = 0.5, kFrontToGoal = 0.5;
/// Where a local model knows one direction only, all subgoals give the same command: another one nearer than this share of its length
/// is not tried again from the same node.
constexpr double kSameCommand = 0.1;
/// A contact edge must move the robot or an object at least this far to be worth a node [m or rad].
constexpr double kMinMove = 1e-4;
/// Extensions after which the search for a cheaper path turns to the next tree, as a multiple of those of the first solution …
constexpr long kPatience = 4;
constexpr long kLeastPatience = 1000;  ///< … or so many
/// Of disturbed steps [J·s]: as sharp as a barrier weight of 1e5/J, far below what a mean of 100 samples resolves; a fifth faster.
constexpr double kSampleComplementarity = 1e-6;
/// Of steps of Coulomb's law [J·s], which also says how far their shifts are followed (docs/theory/cone.md, eq. 18).
constexpr double kCoulombComplementarity = 1e-8;
/// A tree is given up for a new one when the objects have come no nearer the goal, by this share, …
constexpr double kGain = 0.9;
/// … for so many extensions and half of all that it had: how long a tree takes is spread widely, and most that stall stall for good.
constexpr long kLeastStall = 1000;
/// Keeps the seeds of later trees apart from the draws of the search.
constexpr std::uint64_t kTreeSeed = 0x7ee5eed5;
/// Keeps errors of objects apart from the draws of the search.
constexpr std::uint64_t kDisturbanceSeed = 0xd157a2bed;
/// Keeps the samples of local models apart from the draws of the search.
constexpr std::uint64_t kSampleSeed = 0x5ca1ab1e0ddba11;

RegraspCounts& operator+=(RegraspCounts& sum, const RegraspCounts& o) {
  sum.tried += o.tried;
  sum.accepted += o.accepted;
  sum.no_sample += o.no_sample;
  sum.no_path += o.no_path;
  sum.object_moved += o.object_moved;
  sum.failed_step += o.failed_step;
  return sum;
}

struct Totals {
  long steps = 0, linearisations = 0, failed_steps = 0, distrusted = 0;
  RegraspCounts regrasps;

  Totals& operator+=(const Totals& o) {
    steps += o.steps;
    linearisations += o.linearisations;
    failed_steps += o.failed_steps;
    distrusted += o.distrusted;
    regrasps += o.regrasps;
    return *this;
  }
};

/// What a tree has come to.
struct Counts {
  long iterations = 0, nodes = 0;
  Totals totals;
  long cost = 0;  ///< Planner::cost()

  Counts& operator+=(const Counts& o) {
    iterations += o.iterations;
    nodes += o.nodes;
    totals += o.totals;
    return *this;
  }
};

/// Adds counts to those of a run.
void add(const Counts& counts, PlanResult& out) {
  out.iterations += counts.iterations;
  out.nodes += counts.nodes;
  out.steps += counts.totals.steps;
  out.linearisations += counts.totals.linearisations;
  out.failed_steps += counts.totals.failed_steps;
  out.distrusted += counts.totals.distrusted;
  out.regrasps += counts.totals.regrasps;
}

/// Everything one thread needs.
struct Worker {
  explicit Worker(const std::shared_ptr<const Model>& model) : steps(model), locals(model), geometry(*model), least_squares(model->n_a()) {}

  dynamics::StepWorkspace steps;
  dynamics::LocalModelWorkspace locals;
  GeometryWorkspace geometry;
  ConeLeastSquares least_squares;
  dynamics::StepResult step_result;
  dynamics::RolloutResult rollout_result;
  dynamics::LocalModel local;
  Regrasp regrasp;
  Node candidate;
};

/// The threads of a run and their workspaces, shared by its trees.
struct Crew {
  Crew(const std::shared_ptr<const Model>& model, int threads) : pool(threads > 0 ? threads : core::hardware_threads()) {
    for (int i = 0; i < pool.size(); ++i) workers.emplace_back(model);
  }
  core::ThreadPool pool;
  std::vector<Worker> workers;
  std::atomic<long> extensions{0};  ///< of all trees
  std::atomic<bool> over{false};    ///< what is still under way comes too late
};

/// One growth of the tree, from the draw of the subgoal to the new nodes.
struct Item {
  std::uint64_t stream = 0;
  int near = -1;  ///< −1: to be found by the worker
  bool grasp = false;
  bool to_goal = false;
  bool by_place = false;    ///< near by the place of the objects, whatever the posture
  bool in_cones = false;    ///< contact forces stay in their cones (P.7)
  Eigen::VectorXd subgoal;  ///< qᵘ (n_qu)
  Followed near_followed;   ///< of `near`, when this item computed it
  int refined = -1;         ///< the node that it belongs to
  bool distrusted = false;  ///< it is too far from q to build on; the chain then is what is left of the node's edge
  GraspDraw draw;           ///< of a regrasp
  bool stuck = false;       ///< its branches cannot let go of the object at `near`
  int unsupported = -1;     ///< a node at which no branches can
  Eigen::VectorXd command;  ///< that `near` was extended to (n_a); empty: it was not
  std::vector<Node> chain;  ///< new nodes, each the parent of the next
  std::size_t taken = 0;    ///< so many of them were extended towards the subgoal already
  int broken = 0;           ///< edges given up at the end of the chain
  Totals totals;
};

/// Stores the sub-steps of an edge in its node.
void set_edge(const std::vector<dynamics::Knot>& knots, const Model& model, Node& node) {
  const auto n = static_cast<Eigen::Index>(knots.size());
  node.commands.resize(model.n_a(), n);
  node.states.resize(model.n_q(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    node.commands.col(k) = knots[static_cast<std::size_t>(k)].u;
    node.states.col(k) = knots[static_cast<std::size_t>(k)].q;
  }
}

/// qᵘ of the goal.
Eigen::VectorXd goal_configuration(const PlanningProblem& problem, const ObjectSpace& space) {
  if (problem.q_goal.size() > 0) return problem.q_goal;
  const auto& object = problem.model->objects()[static_cast<std::size_t>(problem.goal.object)];
  Eigen::VectorXd q_goal = problem.q_start.head(problem.model->n_qu());
  q_goal.segment(object.q_begin, object.n_q) = space.coordinates(problem.goal.object, problem.goal.X_WG);
  return q_goal;
}

class Planner final : public Growth {
 public:
  /// @param bound  nodes that cost as much to come to are left out [s]
  Planner(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, double bound, Crew& crew,
          PlanResult& result)
      : bound_(bound),
        model_(*problem.model),
        problem_(problem),
        options_(options),
        control_(control),
        result_(result),
        space_(model_),
        chains_(model_),
        drag_(model_, problem.q_start, options.rest_time),
        tree_(space_, global_weights(), inverse_tolerances().cwiseAbs2()),
        crew_(crew),
        items_(static_cast<std::size_t>(round_size(options))) {
    exact_ = options.step_options();
    cold_ = exact_;
    cold_.warm_start = false;
    smoothed_ = exact_;
    smoothed_.warm_start = false;
    if (options.scheme == Scheme::RandomizedFirst || options.scheme == Scheme::RandomizedZeroth)
      smoothed_.tol_complementarity = kSampleComplementarity;
    for (int i = 0; i < kDisturbances; ++i)
      disturbances_.push_back(
          {calc_weights_aside(model_, options.edge_tilt, i), calc_friction_factors(model_, chains_, options.friction_noise, i)});
    q_goal_ = goal_configuration(problem, space_);
    if (problem.goal.region) goal_matters_ = bounded_coordinates(*problem.goal.region);
    weights_ = Eigen::VectorXd::Ones(model_.n_vu());
    if (refines()) weights_ = problem.goal.tol_angle * inverse_tolerances();
  }

  /// Turns grow the tree, from where it was, to so many extensions in all.
  void grow_to(long iterations) { limit_ = iterations; }

  int turn(int worker) override {
    result_.status = take_in(crew_.workers[static_cast<std::size_t>(worker)]);
    counted_.push_back(counts());
    if (worker == 0) report();  // of the calling thread, where signals and callbacks are welcome
    return result_.status == Status::MaxIterations && may_go_on() ? draw_round() : 0;
  }

  void work(int item, int worker) override {
    const auto i = static_cast<std::size_t>(order_[static_cast<std::size_t>(item)]);
    if (!control_.cancelled() && !crew_.over) work_on(items_[i], crew_.workers[static_cast<std::size_t>(worker)]);
  }

  /// About the time that it took: a local model takes as long as two steps, and draws that come to nothing are not for nothing.
  long cost() const override { return iterations_ + totals_.steps + 2 * totals_.linearisations; }

  void report() {
    if (!control_.on_progress || best_ < 0) return;
    core::Progress progress;
    progress.iteration = iterations_;
    progress.best = goal_ratio();
    progress.size = tree_.size();
    control_.on_progress(progress);  // time and share of the budget are those of the run: see place_in_run
  }

  /// Writes the tree and its best path into the result.
  void finish() {
    for (int i = 0; i < tree_.size(); ++i) {
      result_.tree.push_back({tree_[i].parent, tree_[i].edge, world::object_pose(model_, tree_[i].q, problem_.goal.object)});
    }
    if (best_ >= 0 && result_.status != Status::Solved) keep(tree_.path_to(best_), crew_.workers[0]);
  }

  Counts counts() const { return {iterations_, tree_.size(), totals_, cost()}; }
  /// The last ones at which it had cost no more.
  Counts counts_at(long cost) const {
    const auto after = std::find_if(counted_.rbegin(), counted_.rend(), [cost](const Counts& c) { return c.cost <= cost; });
    return after == counted_.rend() ? Counts{} : *after;
  }

  long iterations() const { return iterations_; }
  /// Of the best node: how far the objects are from the goal, in tolerances.
  double goal_ratio() const { return best_ < 0 ? std::numeric_limits<double>::infinity() : tree_[best_].goal_ratio; }

  /// The tree comes no nearer to the goal any more. Trees of jumps, and those that are to have a certain size, never stall.
  bool stalled() const { return options_.stop_at_goal && refines() && iterations_ - last_gain_ > std::max(kLeastStall, iterations_ / 2); }

 private:
  // ---- root ----------------------------------------------------------------------------------------------------------------
  /// Lets the given start settle under the exact dynamics with the robot commanded where it is.
  bool plant_root(Worker& worker) {
    Eigen::VectorXd q = problem_.q_start;
    u_start_ = q.tail(model_.n_a()).cwiseMax(model_.lower()).cwiseMin(model_.upper());
    std::vector<dynamics::Knot> settle;
    worker.steps.forget();
    bool rests = false;
    for (int k = 0; k < kMaxSettleSteps; ++k) {
      const Status status = dynamics::step(model_, {q, u_start_}, exact_, worker.steps, worker.step_result);
      ++totals_.steps;
      if (status != Status::Solved) {
        ++totals_.failed_steps;
        return false;
      }
      const auto& r = worker.step_result;
      if (k == 0) result_.start_penetration = calc_penetration(r);
      const double moved = r.delta.cwiseAbs().maxCoeff();
      rests = moved < kSettled;
      if (rests) break;
      if (k == 0 && moved > 1e-3) result_.start_projected = true;
      dynamics::Knot& knot = settle.emplace_back();
      knot.u = u_start_;
      knot.q = r.q_next;
      q = r.q_next;
    }
    Eigen::VectorXd e(model_.n_vu());
    space_.error(problem_.q_start.data(), q.data(), e.data());
    result_.start_moved = largest_share(model_, e, 1, 1);
    if (!rests && result_.start_moved > kFallen) {
      result_.reason = fmt::format(
          "the objects do not come to rest at the start: after {} steps one has moved by {:.3g} (m or rad); "
          "is it supported?",
          kMaxSettleSteps, result_.start_moved);
      return false;
    }
    Node root;
    root.edge = SegmentKind::Settle;
    root.q = q;
    root.u = u_start_;
    set_edge(settle, model_, root);
    if (!linearise(root, 0, worker, totals_)) return false;
    if (refines()) {
      const Eigen::MatrixXd fine = simulate_fine(problem_.q_start, u_start_, root.commands, false, worker, totals_);
      if (fine.cols() < root.commands.cols()) return false;
      root.followed.q_fine = problem_.q_start;
      if (fine.cols() > 0) root.followed.q_fine = fine.rightCols(1);
      root.followed.disturbed = root.q.replicate(1, disturbs() ? kDisturbances : 0);
    }
    insert(std::move(root), false);
    return true;
  }

  // ---- growth --------------------------------------------------------------------------------------------------------------
  static int round_size(const PlannerOptions& options) {
    return options.stop_at_goal ? std::max(1, options.batch / options.trees) : options.batch;
  }

  /// Takes in what came of a round; the root comes before the first one. @returns MaxIterations: nothing final
  Status take_in(Worker& worker) {
    if (crew_.over) return Status::MaxIterations;
    if (best_ < 0) {
      if (!plant_root(worker)) return Status::NumericalFailure;
      if (options_.stop_at_goal && reaches_goal(best_, worker)) return Status::Solved;
    }
    const int n = std::exchange(drawn_, 0);
    iterations_ += n;
    crew_.extensions += n;
    for (int i = 0; i < n; ++i) {
      Item& item = items_[static_cast<std::size_t>(i)];
      totals_ += item.totals;
      if (item.refined >= 0) judge(item);
      if (item.stuck) tree_.add_stuck(item.near, item.draw.moved);
      if (item.unsupported >= 0) tree_.set_unsupported(item.unsupported);
      totals_.distrusted += item.broken;
      if (item.command.size() > 0) tree_.add_tried(item.near, std::move(item.command));
      if (insert(item, worker)) return Status::Solved;
    }
    return control_.cancelled() ? Status::Cancelled : Status::MaxIterations;
  }

  bool may_go_on() { return iterations_ < limit_ && !crew_.over && !control_.stop() && !stalled() && !cannot_touch(); }

  int draw_round() {
    drawn_ = static_cast<int>(std::min<long>(std::ssize(items_), limit_ - iterations_));
    for (int i = 0; i < drawn_; ++i) draw(items_[static_cast<std::size_t>(i)], iterations_ + i);
    order_.resize(static_cast<std::size_t>(drawn_));
    std::iota(order_.begin(), order_.end(), 0);  // regrasps take longest, and a round as long as its last item
    std::stable_partition(order_.begin(), order_.end(), [&](int i) { return items_[static_cast<std::size_t>(i)].grasp; });
    return drawn_;
  }

  /// No branch moves a geometry that may touch an object, or every contact sample so far failed.
  bool cannot_touch() {
    bool any = false;
    for (int c = 0; c < chains_.size(); ++c) any |= !chains_.object_pairs(c).empty();
    const RegraspCounts& r = totals_.regrasps;
    const bool hopeless = r.tried >= kHopelessSamples && r.no_sample == r.tried;
    if (any && !hopeless) return false;
    result_.reason = any ? fmt::format("the robot cannot touch an object: {} draws of a posture in contact all failed", r.tried)
                         : std::string("the robot cannot touch an object: no pair of a moving link and an object is looked at");
    return true;
  }

  /// SampleSubgoal, and for subgoals that are the goal also Nearest: first each node is taken there once, by its metric, then those near
  /// the goal again.
  void draw(Item& item, long iteration) {
    item.stream = static_cast<std::uint64_t>(iteration) + 1;
    item.distrusted = false;
    item.command.resize(0);
    item.chain.clear();
    item.taken = 0;
    item.broken = 0;
    item.refined = item.unsupported = -1;
    item.stuck = false;
    item.totals = Totals{};
    item.near = -1;
    core::Random random(options_.seed, item.stream << 1);
    item.grasp = random.chance(options_.grasp_probability);
    item.in_cones = refines() && options_.scheme == Scheme::Analytic && random.chance(kInCones);
    item.by_place = item.grasp && refines() && random.chance(kByPlace);
    item.subgoal = q_goal_;
    item.to_goal = random.chance(options_.goal_bias);
    if (item.to_goal) item.near = item.grasp ? tree_.take_for_regrasp() : tree_.take_nearest_to_goal();
    if (item.near >= 0) return;
    if (!item.grasp && refines() && random.chance(kFromFront)) item.near = tree_.take_for_push();
    item.to_goal = item.near >= 0 && random.chance(kFrontToGoal);
    if (item.to_goal) return;
    space_.sample(options_.sample_boxes, random, item.subgoal);
  }

  void work_on(Item& item, Worker& worker) {
    if (item.near < 0 && item.by_place) item.near = tree_.nearest_for_regrasp(item.subgoal);
    if (item.near < 0) item.near = tree_.nearest(item.subgoal);
    if (refines() && tree_[item.near].followed.empty()) {
      item.refined = item.near;
      const Node& node = tree_[item.near];
      const Node& parent = tree_[node.parent];
      Node left;
      item.distrusted = !refine(parent, parent.followed, node, worker, item.totals, item.near_followed, &left);
      if (item.distrusted) {
        item.near = node.parent;
        if (left.q.size() > 0 && complete(parent, item, worker, left)) item.chain.push_back(std::move(left));
        return;
      }
    }
    core::Random random(options_.seed, (item.stream << 1) + 1);
    if (item.grasp) choose_regrasp(item, random);
    const Node& near = tree_[item.near];
    Node node;
    node.parent = item.near;
    const bool grown = item.grasp ? regrasp(item, random, worker, node) : extend(near, item, worker, item.command, node);
    if (!grown || !complete(near, item, worker, node)) return;
    item.chain.push_back(std::move(node));
    const Followed& near_followed = near.followed.empty() ? item.near_followed : near.followed;
    while (refines() && goes_on(item, near) && lengthen(item, near, near_followed, worker)) {
    }
  }

  /// Cost and local model of a new node; false where it is none.
  bool complete(const Node& parent, Item& item, Worker& worker, Node& node) {
    node.pushes = parent.pushes + starts_push(parent, node);
    node.cost = cost_to(parent, node);
    return node.cost < bound_ && linearise(node, item.stream, worker, item.totals);
  }

  /// The last node of the chain is worth another extension: it is a new grasp, or nearer the subgoal than the node before.
  bool goes_on(const Item& item, const Node& near) const {
    const auto& chain = item.chain;
    if (chain.size() >= kLongestChain) return false;
    const Node& last = chain.back();
    if (last.edge == SegmentKind::Regrasp) return true;
    const Node& before = chain.size() > 1 ? chain[chain.size() - 2] : near;
    const double distance = distance_to_target(item, last.q);
    if (item.to_goal && distance <= options_.tolerance_fraction) return true;  // lengthen() looks whether the finer state is there as well
    return distance > options_.tolerance_fraction && distance < kChainProgress * distance_to_target(item, before.q);
  }

  /// One more extension towards the subgoal. False at the end of the chain; its last node is gone when it is not to be built on.
  bool lengthen(Item& item, const Node& near, const Followed& near_followed, Worker& worker) {
    auto& chain = item.chain;
    const bool first = chain.size() == 1;
    const Node& before = first ? near : chain[chain.size() - 2];
    Node& last = chain.back();
    Node left;
    if (!refine(before, first ? near_followed : before.followed, last, worker, item.totals, last.followed, &left)) {
      ++item.broken;
      chain.pop_back();
      if (left.q.size() > 0 && complete(first ? near : chain.back(), item, worker, left)) chain.push_back(std::move(left));
      return false;
    }
    if (item.to_goal && goal_ratio(last.q) <= options_.tolerance_fraction) {
      // It is there, or the two resolutions are too far apart for one more push to bring both there.
      if (goal_ratio(last.followed.q_fine) <= options_.share_when_refined()) return false;
      if (share_of_tolerances(last.q, last.followed.q_fine) > options_.tolerance_fraction + options_.share_when_refined()) return false;
    }
    item.taken = chain.size();
    Node next;
    Eigen::VectorXd command;
    const bool extended = extend(last, item, worker, command, next) && complete(last, item, worker, next);
    if (command.size() > 0) last.tried.push_back(std::move(command));
    if (!extended) return false;
    chain.push_back(std::move(next));
    return true;
  }

  /// Plans are checked at half their sub-step, so the tree carries both states. Jumps and single steps are not refined.
  bool refines() const { return options_.substep && options_.real_regrasps; }

  /// The states after the commands of an edge at half its sub-step (n_q × commands), every step from its state alone, as the checker does; fewer columns
  /// where it ended before.
  Eigen::MatrixXd simulate_fine(Eigen::VectorXd q, Eigen::VectorXd u_last, const Eigen::MatrixXd& commands, bool limit_gap, Worker& worker,
                                Totals& totals) {
    Eigen::MatrixXd states(model_.n_q(), commands.cols());
    worker.steps.forget();
    for (Eigen::Index k = 0; k < commands.cols(); ++k) {
      for (const double s : {0.5, 1.0}) {
        const Eigen::VectorXd u = (1 - s) * u_last + s * commands.col(k);
        ++totals.steps;
        if (dynamics::step(model_, {q, u}, cold_, worker.steps, worker.step_result) != Status::Solved) {
          ++totals.failed_steps;
          return states.leftCols(k);
        }
        q = worker.step_result.q_next;
        if (!limit_gap) continue;
        if (calc_force_gap(model_, worker.step_result, worker.geometry) > kMaxForceGap) return states.leftCols(k);
        const bool own = k > 0 || s == 1;  // what penetrates where an edge starts is not its doing
        if (own && calc_penetration(worker.step_result) > kMaxFinePenetration) return states.leftCols(k);
      }
      states.col(k) = q;
      u_last = commands.col(k);
    }
    return states;
  }

  /// Computes Node::followed of a node whose parent has it. False where the two resolutions disagree: an object about to tip or a
  /// finger about to slip off would not survive the check of the plan; where slippery contacts do not the same; and where a disturbed
  /// path goes elsewhere. Done once, when the node is first built on.
  /// @param left  of an edge that the resolutions disagree on, what comes before; no q where that is nothing
  bool refine(const Node& parent, const Followed& parent_followed, const Node& node, Worker& worker, Totals& totals, Followed& followed,
              Node* left = nullptr) {
    followed.q_fine = node.q;  // says that it was tried, whatever comes out
    const Eigen::MatrixXd fine = simulate_fine(parent_followed.q_fine, parent.u, node.commands, true, worker, totals);
    const Goal& goal = problem_.goal;
    Eigen::VectorXd before(model_.n_vu()), after(model_.n_vu());
    space_.error(parent.q.data(), parent_followed.q_fine.data(), before.data());
    const auto share = [&](const Eigen::VectorXd& e) { return largest_share(model_, e, goal.tol_position, goal.tol_angle); };
    const auto agrees = [&](Eigen::Index k) {
      space_.error(node.states.col(k).data(), fine.col(k).data(), after.data());
      return share(after) <= options_.fidelity_path && share(after - before) <= options_.fidelity_edge;
    };
    const auto holds = [&](const Node& edge, Eigen::MatrixXd& disturbed) {
      return holds_slippery(edge, parent, worker, totals) && holds_disturbed(edge, parent, parent_followed, worker, totals, disturbed);
    };
    const Eigen::Index n = node.commands.cols();
    if (fine.cols() == n && agrees(n - 1)) {
      followed.q_fine = fine.col(n - 1);
      return holds(node, followed.disturbed);
    }
    if (left == nullptr || node.edge != SegmentKind::Contact) return false;
    for (Eigen::Index k = fine.cols() / 2 - 1; k >= 0; --k) {  // half of it: at its end things are about to go wrong
      if (!agrees(k)) continue;
      if (!cut_edge(parent, node, k + 1, fine.col(k), *left) || !holds(*left, left->followed.disturbed)) left->q.resize(0);
      break;
    }
    return false;
  }

  /// The first n sub-steps of an edge. False where they move nothing.
  bool cut_edge(const Node& parent, const Node& node, Eigen::Index n, Eigen::VectorXd q_fine, Node& out) const {
    out.parent = node.parent;
    out.edge = node.edge;
    out.commands = node.commands.leftCols(n);
    out.states = node.states.leftCols(n);
    out.q = out.states.rightCols(1);
    out.u = out.commands.rightCols(1);
    out.followed.q_fine = std::move(q_fine);
    out.tried = {node.u};  // it goes wrong from here
    return moves(parent, out);
  }

  /// A push does the same with every μ at edge_friction of it, against what objects on joints rest on.
  bool holds_slippery(const Node& node, const Node& parent, Worker& worker, Totals& totals) {
    if (node.edge != SegmentKind::Contact || options_.edge_friction == 1) return true;
    dynamics::StepOptions slippery = exact_;
    slippery.friction_scale *= options_.edge_friction;
    Eigen::VectorXd q = parent.q, u = parent.u;
    if (drag_.push(node.commands, slippery, worker.steps, worker.step_result, q, u, totals.steps) != Status::Solved) {
      ++totals.failed_steps;
      return false;
    }
    return share_of_tolerances(node.q, q) <= options_.fidelity_edge;
  }

  static bool starts_push(const Node& parent, const Node& node) {
    return node.edge == SegmentKind::Contact && parent.edge != SegmentKind::Contact;
  }

  bool disturbs() const { return options_.start_noise > 0 || options_.edge_tilt > 0 || options_.friction_noise > 0; }

  /// The objects off by up to start_noise of the tolerances wherever a push starts, by two draws of errors either way, the same in all n-th pushes; gravity
  /// edge_tilt aside; less friction: after every edge they still are within the tolerances of where the tree has them. Pushes that multiply errors, and those
  /// that hold an object by less than that, are left before others are built on them.
  bool holds_disturbed(const Node& node, const Node& parent, const Followed& parent_followed, Worker& worker, Totals& totals,
                       Eigen::MatrixXd& disturbed) {
    if (!disturbs()) return true;
    disturbed = parent_followed.disturbed;
    const Eigen::VectorXd most = options_.start_noise * inverse_tolerances().cwiseInverse();
    Eigen::VectorXd error = Eigen::VectorXd::Zero(model_.n_v());
    const Eigen::Index n = node.commands.cols(), held = n > 0 && options_.edge_tilt > 0 ? kTiltHeld : 0;
    for (const Eigen::Index i : farthest_first(parent, disturbed)) {
      Eigen::VectorXd q = disturbed.col(i);
      if (starts_push(parent, node)) {
        core::Random random(options_.seed ^ kDisturbanceSeed, static_cast<std::uint64_t>(kDisturbances * parent.pushes + i / 2));
        for (int k = 0; k < model_.n_vu(); ++k) error[k] = (i % 2 == 0 ? 1 : -1) * random.uniform(-most[k], most[k]);
        world::retract(model_, q, error, q);
      }
      const Disturbance& other = disturbances_[static_cast<std::size_t>(i)];
      worker.steps.forget();
      for (Eigen::Index k = 0; k < n + held; ++k) {
        const dynamics::StepInput input{q, node.commands.col(std::min(k, n - 1)), &other.tau, nullptr, &other.friction};
        ++totals.steps;
        if (dynamics::step(model_, input, exact_, worker.steps, worker.step_result) != Status::Solved) {
          ++totals.failed_steps;
          return false;
        }
        const bool rests = k >= n && share_of_tolerances(q, worker.step_result.q_next) < kRests;
        q = worker.step_result.q_next;
        if (rests) break;
      }
      if (share_of_tolerances(node.q, q) > 1) return false;
      disturbed.col(i) = q;
    }
    return true;
  }

  /// Disturbed paths in the order in which they are likely to go elsewhere.
  std::array<Eigen::Index, kDisturbances> farthest_first(const Node& node, const Eigen::MatrixXd& disturbed) const {
    std::array<double, kDisturbances> off{};
    std::array<Eigen::Index, kDisturbances> order{};
    for (Eigen::Index i = 0; i < kDisturbances; ++i) {
      order[static_cast<std::size_t>(i)] = i;
      off[static_cast<std::size_t>(i)] = share_of_tolerances(node.q, disturbed.col(i));
    }
    std::ranges::stable_sort(order, std::greater<>{}, [&off](Eigen::Index i) { return off[static_cast<std::size_t>(i)]; });
    return order;
  }

  /// Worst displacement of an object between two configurations, in tolerances of the goal.
  double share_of_tolerances(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
    Eigen::VectorXd e(model_.n_vu());
    space_.error(from.data(), to.data(), e.data());
    return largest_share(model_, e, problem_.goal.tol_position, problem_.goal.tol_angle);
  }

  void judge(Item& item) {
    if (!tree_[item.refined].followed.empty()) {  // another item of the round was first, with the same outcome
      if (item.distrusted) item.chain.clear();
      return;
    }
    set_followed(item.refined, std::move(item.near_followed));
    if (!item.distrusted) return;
    tree_.bury(item.refined);
    ++totals_.distrusted;
  }

  /// Where an item wants the objects when they are at q_u: its subgoal, or of a goal region the nearest place.
  Eigen::VectorXd target(const Item& item, const Eigen::VectorXd& q_u) const { return item.to_goal ? goal_from(q_u) : item.subgoal; }

  Eigen::VectorXd goal_from(const Eigen::VectorXd& q_u) const {
    if (!problem_.goal.region) return q_goal_;
    Eigen::VectorXd q = q_u;
    project(model_, *problem_.goal.region, q);
    return q;
  }

  /// δu* of (P.2), cut or stretched to its length; with `forces`, the smoothed step that gave the local model, also (P.7).
  /// Towards a goal region, coordinates that it leaves free may go anywhere.
  Eigen::VectorXd extension(const LocalModel& local, const Eigen::VectorXd& q_a, const Eigen::VectorXd& e, bool to_goal,
                            const dynamics::StepResult* forces, ConeLeastSquares& least_squares) const {
    const Eigen::VectorXd lower = (model_.lower() - q_a).cwiseMin(0.0), upper = (model_.upper() - q_a).cwiseMax(0.0);
    Eigen::VectorXd delta_u, w = weights_;
    if (to_goal && problem_.goal.region) w = w.cwiseProduct(goal_matters_).eval();
    const Eigen::MatrixXd B = w.asDiagonal() * local.B_u;
    const Eigen::VectorXd we = w.cwiseProduct(e);
    if (forces != nullptr) add_force_cones(*forces, least_squares);
    if (forces == nullptr || !least_squares.solve(B, we, options_.gamma, lower, upper, delta_u))
      solve_bounded_least_squares(B, we, options_.gamma, lower, upper, delta_u);
    const double length = delta_u.norm();
    if (length < 1e-9) return delta_u;
    if (const auto* fixed = std::get_if<FixedLength>(&options_.length)) {
      delta_u *= fixed->length / length;
    } else {
      delta_u *= std::min(1.0, std::get<CappedLength>(options_.length).length / length);
    }
    return delta_u;
  }

  /// Per coordinate of the objects, 1/tolerance of the goal.
  Eigen::VectorXd inverse_tolerances() const { return planning::inverse_tolerances(model_, problem_.goal); }

  /// 1 per coordinate that a goal region bounds, else 0: all three of a rotation when it bounds one of roll, pitch and yaw.
  Eigen::VectorXd bounded_coordinates(const GoalRegion& region) const {
    Eigen::VectorXd out(model_.n_vu());
    for (int i = 0; i < model_.n_vu(); ++i) out[i] = std::isfinite(region.lower[i]) || std::isfinite(region.upper[i]);
    for (const auto& object : model_.objects()) {
      if (object.n_v == 6) out.segment<3>(object.v_begin + 3).setConstant(out.segment<3>(object.v_begin + 3).maxCoeff());
    }
    return out;
  }

  /// Of the path from the root [s].
  double cost_to(const Node& parent, const Node& node) const {
    double cost = parent.cost + (node.edge == SegmentKind::Regrasp ? options_.cost.regrasp : 0.0);
    Eigen::VectorXd u = parent.u;
    for (Eigen::Index k = 0; k < node.commands.cols(); ++k) {
      cost += command_time(model_, u, node.commands.col(k), options_.cost);
      u = node.commands.col(k);
    }
    return cost;
  }

  /// λ + D_λ_u δu in its friction cone, for every contact of the robot with an object that is nearer than kForceReach.
  void add_force_cones(const dynamics::StepResult& step, ConeLeastSquares& least_squares) const {
    least_squares.clear_cones();
    Eigen::MatrixXd G(3, model_.n_a());
    for (std::size_t i = 0; i < step.contacts.size(); ++i) {
      const auto& c = step.contacts[i];
      const double mu = c.contact.friction * exact_.friction_scale;
      if (c.contact.phi > kForceReach || mu <= 0 || !chains_.touches_object(c.contact.pair) || chains_.mask_of_pair(c.contact.pair) == 0)
        continue;
      const auto D = step.D_lambda_u[i];
      G.row(0) = mu * D.row(0);
      G.bottomRows(2) = D.bottomRows(2);
      const double scale = G.cwiseAbs().maxCoeff();
      if (!(scale > 0)) continue;
      G /= scale;
      least_squares.add_cone(G, Eigen::Vector3d(mu * c.lambda[0], c.lambda[1], c.lambda[2]) / scale);
    }
  }

  /// Alg. 3 with joint limits, rolled out exactly.
  /// @param u  the command that is tried; empty where none was worth it, or one like it was tried from this node before
  bool extend(const Node& near, Item& item, Worker& worker, Eigen::VectorXd& u, Node& out) {
    const Eigen::VectorXd q_a = resting_command(near);
    Eigen::VectorXd e(model_.n_vu()), delta_u;
    const Eigen::VectorXd subgoal = target(item, near.local.c_u);
    space_.error(near.local.c_u.data(), subgoal.data(), e.data());
    // Aim with the mean of the two resolutions. A node that is new to the second has only the first: its next command is another one then.
    if (!near.followed.empty()) {
      Eigen::VectorXd difference(model_.n_vu());
      space_.error(near.q.data(), near.followed.q_fine.data(), difference.data());
      e -= 0.5 * difference;
    }
    if (item.in_cones) {  // the tree keeps no forces
      worker.candidate.q = near.q;
      worker.candidate.u = near.u;
      if (!linearise_with_forces(worker.candidate, worker, item.totals)) return false;
    }
    delta_u = extension(near.local, q_a, e, item.to_goal, item.in_cones ? &worker.step_result : nullptr, worker.least_squares);
    if (delta_u.norm() < 1e-9) return false;
    const Eigen::VectorXd wanted = (q_a + delta_u).cwiseMax(model_.lower()).cwiseMin(model_.upper());
    const double same = kSameCommand * (wanted - q_a).norm();
    if (std::any_of(near.tried.begin(), near.tried.end(), [&](const auto& tried) { return (tried - wanted).norm() < same; })) return false;
    if (refines()) u = wanted;
    if (!move(near, wanted, worker, item.totals, out)) return false;
    out.edge = SegmentKind::Contact;
    return moves(near, out);
  }

  /// Nodes that came to nothing only slow the search down.
  bool moves(const Node& from, const Node& to) const {
    Eigen::VectorXd moved(model_.n_vu());
    space_.error(from.q.data(), to.q.data(), moved.data());
    return moved.cwiseAbs().maxCoeff() > kMinMove || (to.q - from.q).tail(model_.n_a()).cwiseAbs().maxCoeff() > kMinMove;
  }

  /// Where the command of an extension starts from: the joints, and what is left of the grip (P.11) or of the squeeze of the command.
  Eigen::VectorXd resting_command(const Node& node) const {
    Eigen::VectorXd u = node.q.tail(model_.n_a());
    if (options_.grip_force > 0) {
      const Eigen::ArrayXd strain = (node.u - u).array();
      const double force = (strain * model_.stiffness().array() / model_.reach().array()).abs().maxCoeff();
      return u + std::min(1.0, options_.grip_force / std::max(force, 1e-9)) * strain.matrix();
    }
    if (options_.squeeze > 0) u += (node.u - u).cwiseMax(-options_.squeeze).cwiseMin(options_.squeeze);
    return u;
  }

  /// Exact dynamics from a node towards the command u: sub-steps up to where a contact would slip far at once, or one step as in the thesis.
  bool move(const Node& from, const Eigen::VectorXd& u, Worker& worker, Totals& totals, Node& to) {
    if (!options_.substep) {
      worker.steps.forget();
      const Status status = dynamics::step(model_, {from.q, u}, exact_, worker.steps, worker.step_result);
      ++totals.steps;
      if (status != Status::Solved) {
        ++totals.failed_steps;
        return false;
      }
      to.q = worker.step_result.q_next;
      to.u = u;
      to.commands = u;
      to.states = to.q;
      return true;
    }
    return roll_out(from, u, *options_.substep, worker, totals, to);
  }

  /// Sub-steps up to where a contact would slip far at once.
  bool roll_out(const Node& from, const Eigen::VectorXd& u, const dynamics::SubstepLimits& limits, Worker& worker, Totals& totals,
                Node& to) {
    worker.steps.forget();
    auto& r = worker.rollout_result;
    const Status status = dynamics::rollout(model_, from.q, from.u, u, exact_, limits, worker.steps, r, dynamics::Overrun::Stop);
    totals.steps += r.steps;
    if (status != Status::Solved && status != Status::MaxIterations) {
      ++totals.failed_steps;
      return false;
    }
    const bool long_slips = options_.friction_law == dynamics::FrictionLaw::Coulomb;  // along which round sides part
    const auto bad = [&](const dynamics::Knot& knot) {
      return braces(knot) || (long_slips && calc_force_gap(model_, knot, worker.geometry) > kMaxForceGap);
    };
    r.knots.erase(std::find_if(r.knots.begin(), r.knots.end(), bad), r.knots.end());
    if (r.knots.empty() || r.min_phi < -kMaxPenetration) return false;
    if (calc_penetration(model_, r.knots.back().q, worker.geometry) > kMaxFinePenetration) return false;  // where no step has looked yet
    to.q = r.knots.back().q;
    to.u = r.knots.back().u;
    set_edge(r.knots, model_, to);
    return true;
  }

  /// The robot presses on itself or on what does not move with more than brace_force.
  bool braces(const dynamics::Knot& knot) const {
    return std::any_of(knot.contacts.begin(), knot.contacts.end(), [&](const dynamics::ContactImpulse& c) {
      const int pair = c.contact.pair;
      return chains_.mask_of_pair(pair) != 0 && !chains_.touches_object(pair) && c.lambda[0] > options_.brace_force * options_.h;
    });
  }

  /// Where a regrasp starts, and the branches that let go. A regrasp after a regrasp would only undo it (3.4.5 (i)): grasp again from
  /// where the first one started. Where the object does not stay when branches let go, others are drawn; where it never does, push instead.
  void choose_regrasp(Item& item, core::Random& random) {
    if (tree_[item.near].edge == SegmentKind::Regrasp) item.near = tree_[item.near].parent;
    const Node& near = tree_[item.near];
    item.grasp = false;
    if (near.unsupported) return;
    for (int k = 0; k < kDraws && !item.grasp; ++k) {
      item.draw = draw_grasp(chains_, options_.sampler, random);
      item.grasp = std::find(near.stuck.begin(), near.stuck.end(), item.draw.moved) == near.stuck.end();
    }
    if (!item.grasp) item.unsupported = item.near;
  }

  /// Distance of the objects from a subgoal, in tolerances of the goal, after the extension (P.2) that the local model at q promises.
  Promise promise(const Eigen::VectorXd& q, Item& item, Worker& worker) {
    Node& node = worker.candidate;
    node.q = q;
    node.u = q.tail(model_.n_a());
    const bool solved =
        item.in_cones ? linearise_with_forces(node, worker, item.totals) : linearise(node, item.stream, worker, item.totals);
    if (!solved) return {std::numeric_limits<double>::infinity(), node.u};
    const Eigen::VectorXd q_a = q.tail(model_.n_a());
    Eigen::VectorXd e(model_.n_vu());
    space_.error(node.local.c_u.data(), target(item, node.local.c_u).data(), e.data());
    const Eigen::VectorXd delta_u =
        extension(node.local, q_a, e, item.to_goal, item.in_cones ? &worker.step_result : nullptr, worker.least_squares);
    e -= node.local.B_u * delta_u;
    if (item.to_goal && problem_.goal.region) e = e.cwiseProduct(goal_matters_).eval();
    return {inverse_tolerances().cwiseProduct(e).norm(), (q_a + delta_u).cwiseMax(model_.lower()).cwiseMin(model_.upper())};
  }

  /// The same distance after the exact extension.
  double simulated_distance(const Eigen::VectorXd& q, const Eigen::VectorXd& command, const Item& item, Worker& worker) {
    Node from, to;
    from.q = q;
    from.u = q.tail(model_.n_a());
    Totals totals;
    const bool moved = move(from, command, worker, totals, to);
    worker.regrasp.steps += totals.steps;
    worker.regrasp.failed_steps += totals.failed_steps;
    worker.steps.forget();  // the regrasp goes on from elsewhere
    return distance_to_target(item, moved ? to.q : q);
  }

  bool regrasp(Item& item, core::Random& random, Worker& worker, Node& node) {
    const Node& near = tree_[item.near];
    if (!options_.real_regrasps) {
      ++item.totals.regrasps.tried;
      const auto sample = sample_contact(model_, chains_, options_.sampler, item.draw, near.q, random, worker.geometry);
      if (!sample) {
        ++item.totals.regrasps.no_sample;
        return false;
      }
      ++item.totals.regrasps.accepted;
      node.q = near.q;
      node.q.tail(model_.n_a()) = sample->q_a;
      node.u = sample->q_a;
      node.commands = sample->q_a;
      node.states = node.q;
    } else {
      const GraspJudge judge{[&](const auto& q) { return promise(q, item, worker); },
                             [&](const auto& q, const auto& command) { return simulated_distance(q, command, item, worker); }};
      const bool held = try_regrasp(model_, chains_, options_, near.q, near.u, item.draw, judge, random, worker.geometry, worker.steps,
                                    worker.regrasp, item.totals.regrasps);
      item.totals.steps += worker.regrasp.steps;
      item.totals.failed_steps += worker.regrasp.failed_steps;
      item.stuck = worker.regrasp.stuck;
      if (!held) return false;
      node.q = worker.regrasp.knots.back().q;
      node.u = worker.regrasp.knots.back().u;
      set_edge(worker.regrasp.knots, model_, node);
    }
    node.edge = SegmentKind::Regrasp;
    return true;
  }

  /// Far from the goal a smooth model sees far; near it the force at a distance would hide the last millimetres.
  dynamics::LocalModelScheme scheme_at(const Node& node, std::uint64_t stream) const {
    return options_.local_model_scheme(stream, std::clamp(options_.goal_sharpening / goal_ratio(node.q), 1.0, options_.goal_sharpening));
  }

  bool take_model(Status status, const Eigen::VectorXd& q_next, const Eigen::MatrixXd& B, Node& node, Totals& totals) const {
    ++totals.linearisations;
    if (status != Status::Solved) {
      ++totals.failed_steps;
      return false;
    }
    node.local.set(q_next, B, model_.n_qu(), model_.n_vu(), options_.gamma);
    return true;
  }

  /// Local model of a node. @param stream  of the samples of a randomised scheme
  bool linearise(Node& node, std::uint64_t stream, Worker& worker, Totals& totals) {
    const Eigen::VectorXd u = resting_command(node);
    const Status status =
        dynamics::calc_local_model(model_, {node.q, u}, scheme_at(node, stream), smoothed_, false, worker.locals, worker.local);
    return take_model(status, worker.local.c, worker.local.B, node, totals);
  }

  /// The same by the analytic scheme; leaves the forces and their derivatives in the worker's step result.
  bool linearise_with_forces(Node& node, Worker& worker, Totals& totals) {
    dynamics::StepOptions smoothed = smoothed_;
    smoothed.smoothing = std::get<dynamics::Analytic>(scheme_at(node, 0));
    smoothed.with_B = true;
    smoothed.with_force_derivatives = true;
    const Eigen::VectorXd u = resting_command(node);
    const Status status = dynamics::step(model_, {node.q, u}, smoothed, worker.steps, worker.step_result);
    return take_model(status, worker.step_result.q_next, worker.step_result.B, node, totals);
  }

  /// Diagonal of a global metric (n_vu), empty for the local one.
  Eigen::VectorXd global_weights() const {
    const auto* global = std::get_if<GlobalMetric>(&options_.metric);
    if (global == nullptr) return {};
    Eigen::VectorXd weights(model_.n_vu());
    for (int i = 0; i < model_.n_vu(); ++i) {
      const bool revolute = model_.dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute;
      weights[i] = revolute ? global->angle : global->position;
    }
    return weights;
  }

  /// The nodes of an item; true when one of them is at the goal and the search ends there.
  bool insert(Item& item, Worker& worker) {
    int parent = item.near;
    for (std::size_t k = 0; k < item.chain.size() && !tree_.buried(parent); ++k) {
      item.chain[k].parent = parent;
      parent = insert(std::move(item.chain[k]), item.to_goal && k < item.taken);
      if (options_.stop_at_goal && reaches_goal(parent, worker)) return true;
    }
    return false;
  }

  /// @param taken  the node was extended towards the goal already
  int insert(Node node, bool taken) {
    std::tie(node.goal_ratio, node.goal_distance) = how_far(node.q, node.followed);
    const double ratio = node.goal_ratio;
    if (node.goal_distance < kGain * least_distance_) {
      least_distance_ = node.goal_distance;
      last_gain_ = iterations_;
    }
    if (options_.record_tree) result_.records.push_back({node.parent, node.edge, iterations_, node.q, node.local.c_u, node.local.B_u});
    const Eigen::VectorXd goal = goal_from(node.local.c_u);
    const int i = tree_.add(std::move(node), goal, taken);
    if (best_ < 0 || ratio < tree_[best_].goal_ratio) best_ = i;
    return i;
  }

  /// Node::goal_ratio and goal_distance: of the farther of the two resolutions, once both are known.
  std::pair<double, double> how_far(const Eigen::VectorXd& q, const Followed& followed) const {
    const double ratio = goal_ratio(q), distance = goal_distance(q);
    if (followed.empty()) return {ratio, distance};
    return {std::max(ratio, goal_ratio(followed.q_fine)), std::max(distance, goal_distance(followed.q_fine))};
  }

  double goal_distance(const Eigen::VectorXd& q) const { return distance(q, goal_from(q.head(model_.n_qu()))); }

  void set_followed(int i, Followed followed) {
    const auto [ratio, distance] = how_far(tree_[i].q, followed);
    tree_.set_followed(i, std::move(followed), ratio, distance);
    if (i != best_) return;
    for (int k = 0; k < tree_.size(); ++k) {
      if (tree_[k].goal_ratio < tree_[best_].goal_ratio) best_ = k;
    }
  }

  /// Distance of the objects from where an item wants them, in tolerances of the goal: all coordinates count, so that an object that is
  /// turned first and brought back later gets nearer all the time.
  double distance_to_target(const Item& item, const Eigen::VectorXd& q) const { return distance(q, target(item, q.head(model_.n_qu()))); }

  double distance(const Eigen::VectorXd& q, const Eigen::VectorXd& q_u) const {
    Eigen::VectorXd e(model_.n_vu());
    space_.error(q.data(), q_u.data(), e.data());
    return inverse_tolerances().cwiseProduct(e).norm();
  }

  // ---- the path ------------------------------------------------------------------------------------------------------------

  double goal_ratio(const Eigen::VectorXd& q) const { return goal_error(model_, q, problem_.goal).share(problem_.goal); }

  /// At the goal at both resolutions, from all disturbed starts; then the path is kept. A regrasp serves nothing at the end, and is cut off there.
  bool reaches_goal(int node, Worker& worker) {
    if (tree_[node].edge == SegmentKind::Regrasp) return false;
    if (goal_ratio(tree_[node].q) > options_.tolerance_fraction) return false;
    if (refines() && !follow_to_goal(node, worker)) return false;
    const std::vector<int> path = tree_.path_to(node);
    if (refines() && !survives_noise(path, worker)) return false;
    keep(path, worker);
    return true;
  }

  bool follow_to_goal(int node, Worker& worker) {
    Followed followed = tree_[node].followed;
    bool holds = true;
    if (followed.empty()) {
      const Node& parent = tree_[tree_[node].parent];
      holds = refine(parent, parent.followed, tree_[node], worker, totals_, followed);
    }
    if (holds && goal_ratio(followed.q_fine) > options_.share_when_refined()) {
      set_followed(node, std::move(followed));
      return false;
    }
    for (const auto& q : followed.disturbed.colwise()) holds = holds && goal_ratio(q) <= 1;
    if (holds) {
      set_followed(node, std::move(followed));
    } else {
      tree_.bury(node);
      ++totals_.distrusted;
    }
    return holds;
  }

  /// A plan that rests on the sixth digit of a command is none: at half the sub-step, with commands that are off by kNoise, it still reaches the goal.
  /// Else everything behind the edge that went elsewhere is taken out of the search.
  bool survives_noise(const std::vector<int>& path, Worker& worker) {
    const int end = follow_with_noise(path, worker);
    if (end != kOnPath) totals_.distrusted += tree_.bury_branch(end);
    return end == kOnPath;
  }

  /// @returns kOnPath: the goal was reached; else the first edge that went elsewhere, or the last one
  int follow_with_noise(const std::vector<int>& path, Worker& worker) {
    core::Random random(options_.seed, 0);
    Eigen::VectorXd q = problem_.q_start, u = u_start_;
    int astray = kOnPath;
    const auto lost = [&astray](int otherwise) { return astray == kOnPath ? otherwise : astray; };
    for (const int i : path) {
      const Node& node = tree_[i];
      Eigen::MatrixXd commands = node.commands;
      for (double& value : commands.reshaped()) value += random.uniform(-kNoise, kNoise);
      const Eigen::MatrixXd states = simulate_fine(q, u, commands, node.edge != SegmentKind::Settle, worker, totals_);
      const bool whole = states.cols() == commands.cols();
      if (states.cols() > 0) q = states.rightCols(1);
      if (commands.cols() > 0) u = commands.rightCols(1);
      const bool held = whole && share_of_tolerances(node.followed.q_fine, q) <= options_.fidelity_edge;
      if (astray == kOnPath && node.parent >= 0 && !held) astray = i;
      if (!whole) return lost(path.back());
    }
    return goal_ratio(q) <= options_.share_when_refined() ? kOnPath : lost(path.back());
  }

  Plan empty_plan() const {
    Plan plan;
    plan.q_start = problem_.q_start;
    plan.u_start = u_start_;
    plan.goal = problem_.goal;
    plan.step = exact_;
    if (options_.substep) plan.substep = *options_.substep;
    return plan;
  }

  void keep(const std::vector<int>& path, Worker& worker) {
    Plan& plan = result_.plan = empty_plan();
    for (const int i : path) {
      if (tree_[i].commands.cols() > 0) plan.segments.push_back(describe_edge(tree_[i], worker));
    }
    cut_motionless_tail(plan);
    const Eigen::VectorXd& q_end = plan.segments.empty() ? plan.q_start : plan.segments.back().knots.back().q;
    plan.error = goal_error(model_, q_end, problem_.goal);
    result_.cost = path_cost(model_, plan, options_.cost);
  }

  /// States along an edge, and the forces of every sub-step: the tree keeps no forces. A jump (regrasps of the thesis) has none.
  Segment describe_edge(const Node& node, Worker& worker) {
    Segment segment{node.edge, {}};
    Eigen::VectorXd q = node.parent < 0 ? problem_.q_start : tree_[node.parent].q;
    worker.steps.forget();
    for (Eigen::Index k = 0; k < node.commands.cols(); ++k) {
      dynamics::Knot knot;
      knot.u = node.commands.col(k);
      knot.q = node.states.col(k);
      if (node.edge != SegmentKind::Regrasp || options_.real_regrasps) {
        ++totals_.steps;
        if (dynamics::step(model_, {q, knot.u}, exact_, worker.steps, worker.step_result) != Status::Solved) {
          ++totals_.failed_steps;
        } else {
          for (const auto& c : worker.step_result.contacts) {
            if (c.active) knot.contacts.push_back(c);
          }
        }
      }
      q = knot.q;
      segment.knots.push_back(std::move(knot));
    }
    return segment;
  }

  /// 3.4.5 (ii): what follows the last motion of the object is dropped.
  void cut_motionless_tail(Plan& plan) {
    if (plan.segments.empty()) return;
    Eigen::VectorXd e(model_.n_vu());
    const Eigen::VectorXd q_end = plan.segments.back().knots.back().q;
    while (!plan.segments.empty()) {
      auto& knots = plan.segments.back().knots;
      while (knots.size() > 1) {
        space_.error(knots[knots.size() - 2].q.data(), q_end.data(), e.data());
        if (e.cwiseAbs().maxCoeff() > 1e-6) break;
        knots.pop_back();
      }
      if (knots.size() > 1 || plan.segments.back().kind != SegmentKind::Regrasp) break;
      plan.segments.pop_back();
    }
  }

  /// What is otherwise than planned, besides where the objects are.
  struct Disturbance {
    Eigen::VectorXd tau;       ///< external force (n_v)
    Eigen::VectorXd friction;  ///< factors of μ (pairs)
  };

  double bound_;
  std::vector<Disturbance> disturbances_;
  const Model& model_;
  const PlanningProblem& problem_;
  const PlannerOptions& options_;
  const core::RunControl& control_;
  PlanResult& result_;
  ObjectSpace space_;
  RobotChains chains_;
  Drag drag_;
  Tree tree_;
  Crew& crew_;
  std::vector<Item> items_;      ///< of a round
  std::vector<int> order_;       ///< in which they are worked on
  int drawn_ = 0;                ///< so many of them were drawn and not yet taken in
  std::vector<Counts> counted_;  ///< after each turn
  dynamics::StepOptions cold_, exact_, smoothed_;
  Eigen::VectorXd q_goal_;        ///< qᵘ of the goal
  Eigen::VectorXd goal_matters_;  ///< of a goal region: bounded_coordinates (n_vu)
  Eigen::VectorXd weights_;       ///< W of (P.2) (n_vu)
  Eigen::VectorXd u_start_;
  long iterations_ = 0, limit_ = 0;
  int best_ = -1;
  double least_distance_ = std::numeric_limits<double>::infinity();  ///< of the objects from the goal, in tolerances
  long last_gain_ = 0;                                               ///< extensions after which it last became less
  Totals totals_;
};

}  // namespace

dynamics::LocalModelScheme PlannerOptions::local_model_scheme(std::uint64_t stream, double sharpening) const {
  if (scheme == Scheme::Exact) return dynamics::Exact{};
  if (scheme == Scheme::Analytic) {
    dynamics::Analytic analytic = smoothing;
    analytic.kappa *= sharpening;
    return analytic;
  }
  dynamics::Sampling sampling = randomized;
  sampling.seed = core::Random(seed ^ kSampleSeed, stream).bits();
  sampling.std_u /= sharpening;  // disturbances reach as far as forces at a distance do, 1/κ
  sampling.std_q /= sharpening;
  if (scheme == Scheme::RandomizedFirst) return dynamics::RandomizedFirstOrder{sampling};
  return dynamics::RandomizedZerothOrder{sampling};
}

dynamics::StepOptions PlannerOptions::step_options() const {
  dynamics::StepOptions step{.h = h, .regularisation = regularisation, .friction_law = friction_law, .friction_scale = friction};
  if (friction_law == dynamics::FrictionLaw::Coulomb) step.tol_complementarity = kCoulombComplementarity;
  return step;
}

void PlannerOptions::validate(const Model& model) const {
  const auto probability = [](std::string_view field, double value) {
    if (!(value >= 0 && value <= 1)) core::throw_invalid(field, fmt::format("{}", value), "a probability in [0, 1]");
  };
  if (threads < 0) core::throw_invalid("planner.threads", std::to_string(threads), "0 (all cores) or more");
  if (batch < 1) core::throw_invalid("planner.batch", std::to_string(batch), "at least 1");
  if (trees < 1) core::throw_invalid("planner.trees", std::to_string(trees), "at least 1");
  if (friction_law == dynamics::FrictionLaw::Coulomb && model.planar_axis())
    core::throw_invalid("planner.friction_law", "coulomb", "anitescu for a planar model");
  if (max_iterations < 1) core::throw_invalid("planner.max_iterations", std::to_string(max_iterations), "at least 1");
  probability("planner.goal_bias", goal_bias);
  cost.validate();
  if (anytime && !stop_at_goal) core::throw_invalid("planner.anytime", "true, with stop_at_goal: false", "stop_at_goal: true");
  probability("planner.grasp_probability", grasp_probability);
  core::require_positive("planner.gamma", gamma);
  core::require_positive("planner.h", h);
  core::require_positive("planner.length", std::visit([](const auto& rule) { return rule.length; }, length));
  core::require_positive("planner.smoothing.kappa", smoothing.kappa);
  dynamics::validate(model, local_model_scheme(0), false);
  if (const auto* global = std::get_if<GlobalMetric>(&metric)) {
    core::require_positive("planner.metric.global.position", global->position);
    core::require_positive("planner.metric.global.angle", global->angle);
  }
  if (!(std::isfinite(goal_sharpening) && goal_sharpening >= 1))
    core::throw_invalid("planner.goal_sharpening", fmt::format("{}", goal_sharpening), "a finite number ≥ 1");
  core::require_positive("planner.fidelity_edge", fidelity_edge);
  core::require_positive("planner.fidelity_path", fidelity_path);
  if (substep) substep->validate();
  if (!(regrasp_friction > 0 && regrasp_friction <= 1))
    core::throw_invalid("planner.regrasp_friction", fmt::format("{}", regrasp_friction), "a number in (0, 1]");
  core::require_positive("planner.rest_time", rest_time);
  core::require_nonnegative("planner.start_noise", start_noise);
  if (!(edge_tilt >= 0 && edge_tilt < std::numbers::pi / 2))
    core::throw_invalid("planner.edge_tilt", fmt::format("{}", edge_tilt), "an angle in [0, π/2) [rad]");
  if (!(friction_noise >= 0 && friction_noise < 1))
    core::throw_invalid("planner.friction_noise", fmt::format("{}", friction_noise), "a share in [0, 1)");
  for (const auto& [name, value] : {std::pair("planner.friction", friction), {"planner.edge_friction", edge_friction}}) {
    if (!(value > 0 && value <= 1)) core::throw_invalid(name, fmt::format("{}", value), "a number in (0, 1]");
  }
  core::require_nonnegative("planner.squeeze", squeeze);
  core::require_nonnegative("planner.grip_force", grip_force);
  if (!(brace_force > 0)) core::throw_invalid("planner.brace_force", fmt::format("{:g}", brace_force), "a number > 0");
  core::require_positive("planner.regrasp_clearance", regrasp_clearance);
  core::require_positive("planner.regrasp_tol_position", regrasp_tol_position);
  core::require_positive("planner.regrasp_tol_angle", regrasp_tol_angle);
  core::require_positive("planner.release_tol_position", release_tol_position);
  core::require_positive("planner.release_tol_angle", release_tol_angle);
  if (grasp_trials < 0) core::throw_invalid("planner.grasp_trials", std::to_string(grasp_trials), "0 or more");
  if (grasp_candidates < 1) core::throw_invalid("planner.grasp_candidates", std::to_string(grasp_candidates), "at least 1");
  if (!(tolerance_fraction > 0 && tolerance_fraction <= 1))
    core::throw_invalid("planner.tolerance_fraction", fmt::format("{}", tolerance_fraction), "a number in (0, 1]");
  if (refined_fraction && !(*refined_fraction >= tolerance_fraction && *refined_fraction <= 1))
    core::throw_invalid("planner.refined_fraction", fmt::format("{}", *refined_fraction),
                        fmt::format("a number in [{}, 1]: tolerance_fraction or more", tolerance_fraction));
  if (sample_boxes.empty()) core::throw_invalid("planner.sample_box", "none", "a box for at least one object");
  for (const auto& box : sample_boxes) {
    if (box.object < 0 || box.object >= static_cast<int>(model.objects().size()))
      core::throw_invalid("planner.sample_box", std::to_string(box.object), "the index of an object");
    const auto& object = model.objects()[static_cast<std::size_t>(box.object)];
    core::require_size("planner.sample_box.lower", box.lower.size(), object.n_v);
    core::require_size("planner.sample_box.upper", box.upper.size(), object.n_v);
    if (!(box.lower.array() <= box.upper.array()).all())
      core::throw_invalid("planner.sample_box", "a lower end above its upper end", "lower ≤ upper");
  }
}

namespace {

/// A coordinate of an object that the goal bounds. Nothing to say about those without limits.
void require_in_range(const Model& model, const Goal& goal, int i, double lower, double upper) {
  const auto& dof = model.dofs()[static_cast<std::size_t>(i)];
  const double tolerance = dof.kind == world::DofKind::Revolute ? goal.tol_angle : goal.tol_position;
  if (lower <= dof.upper + tolerance && upper >= dof.lower - tolerance) return;
  const std::string given =
      lower == upper ? fmt::format("{} = {}", dof.name, lower) : fmt::format("{} in [{}, {}]", dof.name, lower, upper);
  core::throw_invalid("goal", given, fmt::format("a value in its range [{}, {}]", dof.lower, dof.upper));
}

void require_region(const Model& model, const GoalRegion& region) {
  core::require_size("goal.region.lower", region.lower.size(), model.n_vu());
  core::require_size("goal.region.upper", region.upper.size(), model.n_vu());
  for (int i = 0; i < model.n_vu(); ++i) {
    if (!(region.lower[i] <= region.upper[i]))
      core::throw_invalid("goal.region",
                          fmt::format("{} in [{}, {}]", model.dofs()[static_cast<std::size_t>(i)].name, region.lower[i], region.upper[i]),
                          "lower ≤ upper");
  }
}

/// Inside the range of the object's joint, and, where the goal is one pose, not inside what cannot move by more than its tolerance.
void require_reachable_goal(const PlanningProblem& problem) {
  const Model& model = *problem.model;
  const Goal& goal = problem.goal;
  if (goal.region) require_region(model, *goal.region);
  const Eigen::VectorXd q_goal = goal_configuration(problem, ObjectSpace(model));
  for (int i = 0; i < model.n_vu(); ++i) {
    const auto& dof = model.dofs()[static_cast<std::size_t>(i)];
    if (!std::isfinite(dof.lower) && !std::isfinite(dof.upper)) continue;
    const double x = q_goal[model.objects()[static_cast<std::size_t>(dof.owner)].q_begin];  // hinge or slider
    require_in_range(model, goal, i, goal.region ? goal.region->lower[i] : x, goal.region ? goal.region->upper[i] : x);
  }
  if (goal.region) return;
  Eigen::VectorXd q = problem.q_start;
  q.head(model.n_qu()) = q_goal;
  GeometryWorkspace work(model);
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  contact::query(model, work.kinematics, {}, work.contact_work, work.contacts);
  const int body = model.objects()[static_cast<std::size_t>(goal.object)].body;
  for (const auto& c : work.contacts) {
    const auto& pair = model.pairs()[static_cast<std::size_t>(c.pair)];
    const auto& a = model.geometries()[static_cast<std::size_t>(pair.geometry_a)];
    const auto& b = model.geometries()[static_cast<std::size_t>(pair.geometry_b)];
    const bool fixed = model.bodies()[static_cast<std::size_t>(b.body)].dofs.empty();  // a fixed body, or the base of a robot
    if (a.body != body || !fixed || c.phi > -(goal.tol_position + kMaxPenetration)) continue;
    core::throw_invalid("goal", fmt::format("a pose in which '{}' is {:.3g} m inside '{}'", a.name, -c.phi, b.name),
                        "one outside everything that cannot move");
  }
}

double seconds_since(core::RunControl::Clock::time_point start) {
  return std::chrono::duration<double>(core::RunControl::Clock::now() - start).count();
}

/// What a tree reports, as part of a run that had so many extensions before it.
void place_in_run(const PlannerOptions& options, const core::RunControl& control, core::RunControl::Clock::time_point start, long before,
                  core::Progress& progress) {
  progress.iteration += before;
  progress.elapsed_s = seconds_since(start);
  progress.fraction = static_cast<double>(progress.iteration) / options.max_iterations;
  if (!control.deadline) return;
  const double budget_s = std::chrono::duration<double>(*control.deadline - start).count();
  progress.fraction = std::max(progress.fraction, progress.elapsed_s / budget_s);
}

/// A tree that may go on to grow.
struct GrowingTree {
  GrowingTree(const PlanningProblem& problem, const PlannerOptions& given, std::uint64_t number, const core::RunControl& control,
              Crew& crew)
      : options(with_seed(given, number)), planner(problem, options, control, std::numeric_limits<double>::infinity(), crew, found) {}
  GrowingTree(const GrowingTree&) = delete;
  GrowingTree& operator=(const GrowingTree&) = delete;

  const PlannerOptions options;
  PlanResult found;
  Planner planner;

 private:
  static PlannerOptions with_seed(PlannerOptions options, std::uint64_t number) {
    if (number > 0) options.seed = core::Random(options.seed ^ kTreeSeed, number).bits();
    return options;
  }
};

/// The trees of a run, until a path is found or the budget is used up: `trees` of them side by side, each until it stalls.
class Search {
 public:
  Search(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control,
         core::RunControl::Clock::time_point start)
      : problem_(problem), options_(options), control_(control), following_(control), crew_(problem.model, options.threads) {
    if (!control.on_progress) return;
    following_.on_progress = [this, start](core::Progress progress) {
      progress.best = nearest_ = std::min(nearest_, progress.best);
      progress.iteration = crew_.extensions;
      if (std::exchange(reported_, progress.iteration) == progress.iteration) return;
      place_in_run(options_, control_, start, 0, progress);
      control_.on_progress(progress);
    };
  }

  void run(PlanResult& out) {
    const int n = options_.stop_at_goal ? options_.trees : 1;
    for (int i = 0; i < n; ++i) lanes_.push_back({(options_.max_iterations + n - 1 - i) / n});
    run_lanes(crew_.pool, n, [this](int lane, Growth* ended, long clock) {
      return next(lanes_[static_cast<std::size_t>(lane)], ended != nullptr, clock);
    });

    for (const auto& tree : trees_) {
      if (tree && !crew_.over) keep_better(tree.get());
    }
    best_->planner.report();
    best_->planner.finish();
    out = std::move(best_->found);
    out.status = status_ == Status::MaxIterations && control_.cancelled() ? Status::Cancelled : status_;
    out.reason = std::move(reason_);
    out.seed = options_.seed;
    add(dropped_, out);
    for (const auto& tree : trees_) {
      if (!tree) continue;
      const auto lane = std::find_if(lanes_.begin(), lanes_.end(), [&](const Lane& l) { return l.tree == tree.get(); });
      add(crew_.over && lane != lanes_.end() ? tree->planner.counts_at(end_ - lane->start) : tree->planner.counts(), out);
    }
  }

 private:
  struct Lane {
    long left;                    ///< extensions
    GrowingTree* tree = nullptr;  ///< that grows
    long start = 0;               ///< clock when it had cost nothing
  };

  /// The next tree of a lane; what is known of others is what had ended by the same clock.
  Growth* next(Lane& lane, bool ended, long clock) {
    if (crew_.over) return nullptr;  // a tree that would have ended later
    if (ended) take_end(lane, clock);
    if (crew_.over || lane.left <= 0 || (control_.stop() && !trees_.empty())) return nullptr;
    trees_.push_back(std::make_unique<GrowingTree>(problem_, options_, trees_.size(), following_, crew_));
    lane.tree = trees_.back().get();
    lane.start = clock;
    lane.tree->planner.grow_to(lane.left);
    return &lane.tree->planner;
  }

  void take_end(Lane& lane, long clock) {
    GrowingTree& tree = *std::exchange(lane.tree, nullptr);
    lane.left -= tree.planner.iterations();
    const Status status = tree.found.status;
    if (status == Status::Solved || status == Status::NumericalFailure || !tree.found.reason.empty()) {
      status_ = status;
      reason_ = tree.found.reason;
      end_ = clock;
      best_ = &tree;
      crew_.over = true;
    } else {
      keep_better(&tree);
    }
  }

  /// Of two trees that have ended the one whose objects are nearer the goal; the other one goes.
  void keep_better(GrowingTree* tree) {
    if (tree == best_) return;
    GrowingTree* worse = best_;
    if (best_ == nullptr || tree->planner.goal_ratio() < best_->planner.goal_ratio()) {
      best_ = tree;
    } else {
      worse = tree;
    }
    if (worse == nullptr) return;
    dropped_ += worse->planner.counts();
    std::find_if(trees_.begin(), trees_.end(), [worse](const auto& t) { return t.get() == worse; })->reset();
  }

  const PlanningProblem& problem_;
  const PlannerOptions& options_;
  const core::RunControl& control_;
  core::RunControl following_;
  Crew crew_;
  std::vector<std::unique_ptr<GrowingTree>> trees_;
  std::vector<Lane> lanes_;
  GrowingTree* best_ = nullptr;
  Counts dropped_;
  double nearest_ = std::numeric_limits<double>::infinity();
  long reported_ = 0;   ///< extensions
  long end_ = 0;        ///< clock of what ended the run
  std::string reason_;  ///< of the end
  Status status_ = Status::MaxIterations;
};

/// Grows one tree after the other for cheaper paths, until the deadline, the budget or a cancel.
void improve(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control,
             core::RunControl::Clock::time_point start, PlanResult& best) {
  const long patience = std::max(kLeastPatience, kPatience * best.iterations);
  core::RunControl following = control;
  if (control.on_progress) {
    following.on_progress = [&](core::Progress progress) {
      progress.best = best.plan.error.share(best.plan.goal);
      progress.cost = best.cost;
      place_in_run(options, control, start, best.iterations, progress);
      control.on_progress(progress);
    };
  }
  Crew crew(problem.model, options.threads);
  for (std::uint64_t tree = 1; best.iterations < options.max_iterations && !control.stop(); ++tree) {
    PlannerOptions next = options;
    next.seed = core::Random(options.seed, ~tree).bits();
    next.trees = 1;
    next.record_tree = false;
    next.max_iterations = static_cast<int>(std::min(patience, options.max_iterations - best.iterations));
    PlanResult found;
    Planner planner(problem, next, following, best.cost, crew, found);
    planner.grow_to(next.max_iterations);
    run_lanes(crew.pool, 1, [&planner](int, Growth* ended, long) { return ended == nullptr ? &planner : nullptr; });
    add(planner.counts(), best);
    if (found.status == Status::NumericalFailure) break;
    if (found.status != Status::Solved || found.cost >= best.cost) continue;
    best.plan = std::move(found.plan);
    best.cost = found.cost;
    best.improvements.push_back({found.cost, best.iterations, seconds_since(start)});
  }
  best.status = control.cancelled() ? Status::Cancelled : Status::Solved;
}

}  // namespace

Status plan(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, PlanResult& result) {
  const auto start = core::RunControl::Clock::now();
  if (!problem.model) core::throw_invalid("problem.model", "nothing", "a model");
  world::require_configuration(*problem.model, "start", problem.q_start);
  options.validate(*problem.model);
  if (problem.goal.object < 0 || problem.goal.object >= static_cast<int>(problem.model->objects().size())) {
    core::throw_invalid("goal.object", std::to_string(problem.goal.object), "the index of an object");
  }
  core::require_positive("goal.tol_position", problem.goal.tol_position);
  core::require_positive("goal.tol_angle", problem.goal.tol_angle);
  if (problem.q_goal.size() > 0) core::require_size("problem.q_goal", problem.q_goal.size(), problem.model->n_qu());
  require_reachable_goal(problem);

  result = PlanResult{};
  Search(problem, options, control, start).run(result);
  if (result.status == Status::Solved) {
    result.improvements.push_back({result.cost, result.iterations, seconds_since(start)});
    if (options.anytime) improve(problem, options, control, start, result);
  }
  result.wall_s = seconds_since(start);
  return result.status;
}

}  // namespace stiction::planning
