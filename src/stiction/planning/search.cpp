#include "stiction/planning/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <memory>
#include <utility>

#include "stiction/core/parallel.hpp"
#include "stiction/core/random.hpp"
#include "stiction/planning/tree_search.hpp"

namespace stiction::planning {
namespace {

using core::Status;

/// Keeps the seeds of later trees apart from the random draws of the first one.
constexpr std::uint64_t kTreeSeed = 0x7ee5eed5;

/// Options of two trees in three, with less friction: objects slip out of the fingers before these hold them aloft, where they could not let
/// go, and jam less between fingers and support. Not in planar scenes, where friction is all that moves things, nor with margins, which try
/// less friction anyway.
PlannerOptions slippery(PlannerOptions options, const world::Model& model) {
  const bool coulomb = options.step_options(model).friction_law == dynamics::FrictionLaw::Coulomb;
  if (options.uses(Mechanism::SlipperyTrees) && coulomb && !options.margins)
    options.friction = std::min(options.friction, threshold::kSlippery);
  return options;
}

/// A tree that grows in this run.
struct GrowingTree {
  std::unique_ptr<TreeSearch> search;
  int number = 0;  ///< number in the run, from 0
  int told = 0;    ///< number of nodes that were reported to GrowthSink
};

/// Grows trees side by side in rounds, so that the plan depends neither on the number of threads nor on their speed.
class Search {
 public:
  Search(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
         const GrowthSink& grown, int trees, double bound)
      : slippery_options_(slippery(options, *problem.model)),
        setting_(problem, options),
        slippery_(problem, slippery_options_),
        u_start_(u_start),
        control_(control),
        grown_(grown),
        pool_(options.threads > 0 ? options.threads : core::hardware_threads()),
        unstopped_(problem.model, to_the_end_),
        bound_(bound),
        trees_(static_cast<std::size_t>(trees)) {
    for (int i = 0; i < pool_.size(); ++i) scratch_.emplace_back(problem.model, control);
  }

  /// Runs Algorithm 2 for several trees. @param budget  number of extensions
  void run(long budget, PlanResult& out) {
    out.status = grow(budget, out);
    if (out.status != Status::Solved) keep_best(out);
    for (const GrowingTree& tree : trees_) count(tree);
  }

  /// Adds what run() counted to the counts of `out`.
  void add_counts(PlanResult& out) const {
    out.iterations += iterations_;
    out.nodes += nodes_;
    out.steps += totals_.steps;
    out.failed_steps += totals_.failed_steps;
    out.linearisations += totals_.linearisations;
    out.distrusted += totals_.distrusted;
    out.regrasps += totals_.regrasps;
    for (const ThreadScratch& scratch : scratch_) out.profile += scratch.profile.profile();
    out.profile += unstopped_.profile.profile();
  }

  /// Nodes at which regrasps were rejected.
  std::vector<RefusedMoves> take_refused() { return std::move(refused_); }

 private:
  struct Item {
    GrowingTree* tree;
    Expansion expansion;
  };

  Status grow(long budget, PlanResult& out) {
    for (GrowingTree& tree : trees_) {
      if (!plant(tree, out)) return Status::NumericalFailure;
      if (tree.search->reaches_goal(0, unstopped_)) return solve(tree, 0, out);
    }
    while (iterations_ < budget && !control_.stop() && !cannot_touch(out)) {
      draw_round(std::min<long>(threshold::kBatch, budget - iterations_));                              // SampleSubgoal
      pool_.run(static_cast<int>(round_.size()), [&](int item, int worker) { expand(item, worker); });  // Nearest, Extend
      for (Item& item : round_) {                                                                       // AddNode
        ++iterations_;
        const int node = item.tree->search->insert(item.expansion, scratch_[0]);
        if (node >= 0) return solve(*item.tree, node, out);  // GoalReached
      }
      report();
      for (GrowingTree& tree : trees_) {
        if (tree.search->stalled() && !replace(tree, out)) return Status::NumericalFailure;
      }
    }
    return control_.status_when_stopped();
  }

  /// Plants a new tree. If the start does not rest with less friction, the tree has the friction of the scene.
  bool plant(GrowingTree& tree, PlanResult& out) {
    const ProfileClock::Scope scope(unstopped_.profile, Activity::Ends);
    const bool slips = planted_ % 3 != 2 && plant(slippery_, tree, out);
    if (!slips && !plant(setting_, tree, out)) return false;
    ++planted_;
    return true;
  }

  bool plant(const Setting& setting, GrowingTree& tree, PlanResult& out) {
    const std::uint64_t seed = setting.options.seed;
    out.reason.clear();
    tree = {
        std::make_unique<TreeSearch>(
            setting, u_start_, planted_ == 0 ? seed : core::Random(seed ^ kTreeSeed, static_cast<std::uint64_t>(planted_)).bits(), bound_),
        planted_, 0};
    return tree.search->plant_root(unstopped_, out);
  }

  /// Replaces a tree that stalled. The best stalled tree is kept for its best path.
  bool replace(GrowingTree& tree, PlanResult& out) {
    count(tree);
    if (!stalled_ || tree.search->goal_ratio() < stalled_->goal_ratio()) stalled_ = std::move(tree.search);
    return plant(tree, out);
  }

  void draw_round(long size) {
    round_.clear();
    const ProfileClock::Scope scope(scratch_[0].profile, Activity::Selection);
    for (long i = 0; i < size; ++i) {
      GrowingTree& tree = trees_[static_cast<std::size_t>(i) % trees_.size()];
      round_.push_back({&tree, tree.search->draw()});
    }
    // Regrasps take longest. They start first, because a round ends with its last item.
    std::ranges::stable_partition(round_, [](const Item& item) { return item.expansion.grasp; });
  }

  void expand(int item, int worker) {
    Item& one = round_[static_cast<std::size_t>(item)];
    one.tree->search->expand(one.expansion, scratch_[static_cast<std::size_t>(worker)]);
  }

  bool cannot_touch(PlanResult& out) {
    bool any = false;
    for (int c = 0; c < setting_.chains.size(); ++c) any |= !setting_.chains.object_pairs(c).empty();
    RegraspCounts r = totals_.regrasps;
    for (const GrowingTree& tree : trees_) r += tree.search->totals().regrasps;
    const bool hopeless = r.tried >= threshold::kHopelessSamples && r.no_sample == r.tried;
    if (any && !hopeless) return false;
    out.reason = any ? fmt::format("the robot cannot touch an object: {} draws of a posture in contact all failed", r.tried)
                     : std::string("the robot cannot touch an object: no pair of a moving link and an object is looked at");
    return true;
  }

  Status solve(GrowingTree& tree, int node, PlanResult& out) {
    take_path(*tree.search, node, true, out);
    tell(tree);
    return Status::Solved;
  }

  void keep_best(PlanResult& out) {
    TreeSearch* best = stalled_.get();
    for (const GrowingTree& tree : trees_) {
      TreeSearch* const search = tree.search.get();
      if (search == nullptr || search->tree().size() == 0) continue;
      if (best == nullptr || search->goal_ratio() < best->goal_ratio()) best = search;
    }
    if (best != nullptr) take_path(*best, best->tree().best(), !control_.stop(), out);
  }

  void take_path(TreeSearch& search, int node, bool forces, PlanResult& out) {
    const ProfileClock::Scope scope(unstopped_.profile, Activity::Ends);
    out.plan = search.plan_to(node, forces, unstopped_);
    out.cost = path_cost(setting_.model, out.plan, {});
    const Tree& tree = search.tree();
    for (int i = 0; i < tree.size(); ++i)
      out.tree.push_back({tree[i].parent, tree[i].edge, world::object_pose(setting_.model, tree[i].q, setting_.problem.goal.object)});
  }

  void count(const GrowingTree& tree) {
    if (!tree.search) return;
    nodes_ += tree.search->tree().size();
    totals_ += tree.search->totals();
    tree.search->add_refused(refused_);
  }

  void report() {
    for (GrowingTree& tree : trees_) tell(tree);
    if (!control_.on_progress) return;
    core::Progress progress;
    progress.iteration = iterations_;
    progress.best = stalled_ ? stalled_->goal_ratio() : std::numeric_limits<double>::infinity();
    for (const GrowingTree& tree : trees_) {
      progress.best = std::min(progress.best, tree.search->goal_ratio());
      progress.size += tree.search->tree().size();
    }
    control_.on_progress(progress);
  }

  void tell(GrowingTree& growing) {
    const Tree& tree = growing.search->tree();
    if (!grown_ || growing.told == tree.size()) return;
    Growth growth;
    growth.tree = growing.number;
    growth.first = growing.told;
    growth.best = tree.best();
    growth.best_ratio = growing.search->goal_ratio();
    growth.q.resize(setting_.model.n_q(), tree.size() - growing.told);
    growth.u.resize(setting_.model.n_a(), growth.q.cols());
    for (int i = growing.told; i < tree.size(); ++i) {
      growth.parents.push_back(tree[i].parent);
      growth.q.col(i - growing.told) = tree[i].q;
      growth.u.col(i - growing.told) = tree[i].u;
    }
    growing.told = tree.size();
    grown_(growth);
  }

  const PlannerOptions slippery_options_;
  const Setting setting_, slippery_;
  const Eigen::VectorXd& u_start_;
  const core::RunControl& control_;
  const GrowthSink& grown_;
  core::ThreadPool pool_;
  const core::RunControl to_the_end_;
  std::deque<ThreadScratch> scratch_;  // one per thread
  ThreadScratch unstopped_;            // for roots and paths, which are made even if the run was stopped
  const double bound_;                 // paths must cost less than this [s]
  std::vector<GrowingTree> trees_;
  std::unique_ptr<TreeSearch> stalled_;
  std::vector<Item> round_;
  int planted_ = 0;
  long iterations_ = 0, nodes_ = 0;  // nodes_ and totals_ count the trees that stalled, and after run() all trees
  Totals totals_;
  std::vector<RefusedMoves> refused_;  // counted like totals_
};

/// Run control of a search that is part of a run: its reports of progress include the extensions made before.
core::RunControl part_of_run(const PlannerOptions& options, const core::RunControl& control, core::RunControl::Clock::time_point start,
                             const PlanResult& before, bool solved) {
  core::RunControl out = control;
  if (!control.on_progress) return out;
  out.on_progress = [&options, &control, start, &before, solved](core::Progress progress) {
    progress.iteration += before.iterations;
    progress.elapsed_s = core::seconds_since(start);
    progress.fraction = static_cast<double>(progress.iteration) / options.max_iterations;
    if (control.deadline) {
      const double budget_s = std::chrono::duration<double>(*control.deadline - start).count();
      progress.fraction = std::max(progress.fraction, progress.elapsed_s / budget_s);
    }
    if (solved) {
      progress.best = before.plan.error.share(before.plan.goal);
      progress.cost = before.cost;
    }
    control.on_progress(progress);
  };
  return out;
}

}  // namespace

void search(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
            core::RunControl::Clock::time_point start, const GrowthSink& grown, PlanResult& out) {
  const PlanResult nothing;
  const core::RunControl part = part_of_run(options, control, start, nothing, false);
  Search first(problem, u_start, options, part, grown, threshold::kTrees, std::numeric_limits<double>::infinity());
  first.run(options.max_iterations, out);
  first.add_counts(out);
  out.refused = first.take_refused();
  out.seed = options.seed;
}

void improve(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
             core::RunControl::Clock::time_point start, const PlanSink& found, PlanResult& best) {
  const long patience = std::max(threshold::kLeastPatience, threshold::kPatience * best.iterations);
  const core::RunControl part = part_of_run(options, control, start, best, true);
  for (std::uint64_t tree = 1; best.iterations < options.max_iterations && !control.stop(); ++tree) {
    PlannerOptions next = options;
    next.seed = core::Random(options.seed, ~tree).bits();
    PlanResult next_best;
    Search another(problem, u_start, next, part, {}, 1, best.cost);
    another.run(std::min<long>(patience, options.max_iterations - best.iterations), next_best);
    another.add_counts(best);
    if (next_best.status == Status::NumericalFailure) break;
    if (next_best.status != Status::Solved || next_best.cost >= best.cost) continue;
    best.plan = std::move(next_best.plan);
    best.cost = next_best.cost;
    best.wall_s = core::seconds_since(start);
    best.improvements.push_back({best.cost, best.iterations, best.wall_s});
    if (found) found(best);
  }
  best.status = control.cancelled() ? Status::Cancelled : Status::Solved;
}

}  // namespace stiction::planning
