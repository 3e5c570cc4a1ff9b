#include "stiction/planning/forest.hpp"

#include <algorithm>
#include <utility>

#include "stiction/core/random.hpp"

namespace stiction::planning {
namespace {

using core::Status;

/// Keeps the seeds of later trees apart from the draws of the search.
constexpr std::uint64_t kTreeSeed = 0x7ee5eed5;
/// Every second tree plans with at most this share of the friction: what it pushes slips out of its fingers before they hold it aloft, where they
/// could not let go of it any more (docs/lab/grasp_candidates.md).
constexpr double kSlippery = 0.7;

/// Extensions after which the search for a cheaper path turns to the next tree, as a multiple of those of the first solution …
constexpr long kPatience = 4;
constexpr long kLeastPatience = 1000;  ///< … or so many

/// What a tree reports, as part of a run that had so many extensions before it.
void place_in_run(const PlannerOptions& options, const core::RunControl& control, core::RunControl::Clock::time_point start, long before,
                  core::Progress& progress) {
  progress.iteration += before;
  progress.elapsed_s = core::seconds_since(start);
  progress.fraction = static_cast<double>(progress.iteration) / options.max_iterations;
  if (!control.deadline) return;
  const double budget_s = std::chrono::duration<double>(*control.deadline - start).count();
  progress.fraction = std::max(progress.fraction, progress.elapsed_s / budget_s);
}

void add(const Counts& counts, PlanResult& out) {
  out.iterations += counts.iterations;
  out.nodes += counts.nodes;
  out.steps += counts.totals.steps;
  out.linearisations += counts.totals.linearisations;
  out.failed_steps += counts.totals.failed_steps;
  out.distrusted += counts.totals.distrusted;
  out.regrasps += counts.totals.regrasps;
}

/// A tree that may go on to grow.
struct GrowingTree {
  GrowingTree(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& given, std::uint64_t number,
              const core::RunControl& control, Crew& crew)
      : options(of_tree(given, number)), search(problem, u_start, options, control, std::numeric_limits<double>::infinity(), crew, found) {}
  GrowingTree(const GrowingTree&) = delete;
  GrowingTree& operator=(const GrowingTree&) = delete;

  const PlannerOptions options;
  PlanResult found;
  TreeSearch search;

 private:
  static PlannerOptions of_tree(PlannerOptions options, std::uint64_t number) {
    if (number > 0) options.seed = core::Random(options.seed ^ kTreeSeed, number).bits();
    // By Anitescu's law what slides opens up, so that a plan that slips is another motion where it sticks in the world.
    if (number % 2 == 1 && options.friction_law == dynamics::FrictionLaw::Coulomb) options.friction = std::min(options.friction, kSlippery);
    return options;
  }
};

/// The trees of a run, until a path is found or the budget is used up: `trees` of them side by side, each until it stalls.
class Forest {
 public:
  Forest(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
         core::RunControl::Clock::time_point start, const GrowthSink& grown)
      : problem_(problem),
        u_start_(u_start),
        options_(options),
        control_(control),
        following_(control),
        grown_(grown),
        crew_(problem.model, options.threads, control) {
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
    core::run_lanes(crew_.pool, n, [this](int lane, core::LaneTask* ended, long clock) {
      return next(lanes_[static_cast<std::size_t>(lane)], ended != nullptr, clock);
    });

    for (const auto& tree : trees_) {
      if (tree && !crew_.over) keep_better(tree.get());
    }
    best_->search.report();
    best_->search.finish();
    out = std::move(best_->found);
    out.status = status_ == Status::MaxIterations && control_.cancelled() ? Status::Cancelled : status_;
    out.reason = std::move(reason_);
    out.seed = options_.seed;
    add(dropped_, out);
    for (const auto& tree : trees_) {
      if (!tree) continue;
      const auto lane = std::find_if(lanes_.begin(), lanes_.end(), [&](const Lane& l) { return l.tree == tree.get(); });
      add(crew_.over && lane != lanes_.end() ? tree->search.counts_at(end_ - lane->start) : tree->search.counts(), out);
    }
  }

 private:
  struct Lane {
    long left;                    ///< extensions
    GrowingTree* tree = nullptr;  ///< that grows
    long start = 0;               ///< clock when it had cost nothing
  };

  /// The next tree of a lane; what is known of others is what had ended by the same clock.
  core::LaneTask* next(Lane& lane, bool ended, long clock) {
    if (crew_.over) return nullptr;  // a tree that would have ended later
    if (ended) take_end(lane, clock);
    if (crew_.over || lane.left <= 0 || (control_.stop() && !trees_.empty())) return nullptr;
    trees_.push_back(std::make_unique<GrowingTree>(problem_, u_start_, options_, trees_.size(), following_, crew_));
    lane.tree = trees_.back().get();
    lane.start = clock;
    if (grown_) watch(lane.tree->search, static_cast<int>(trees_.size()) - 1);
    lane.tree->search.grow_to(lane.left);
    return &lane.tree->search;
  }

  void watch(TreeSearch& search, int number) {
    search.watch([this, number](Growth growth) {
      growth.tree = number;
      grown_(growth);
    });
  }

  void take_end(Lane& lane, long clock) {
    GrowingTree& tree = *std::exchange(lane.tree, nullptr);
    lane.left -= tree.search.iterations();
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
    if (best_ == nullptr || tree->search.goal_ratio() < best_->search.goal_ratio()) {
      best_ = tree;
    } else {
      worse = tree;
    }
    if (worse == nullptr) return;
    dropped_ += worse->search.counts();
    std::find_if(trees_.begin(), trees_.end(), [worse](const auto& t) { return t.get() == worse; })->reset();
  }

  const PlanningProblem& problem_;
  const Eigen::VectorXd& u_start_;
  const PlannerOptions& options_;
  const core::RunControl& control_;
  core::RunControl following_;
  const GrowthSink& grown_;
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

}  // namespace

void grow_forest(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                 const core::RunControl& control, core::RunControl::Clock::time_point start, const GrowthSink& grown, PlanResult& out) {
  Forest(problem, u_start, options, control, start, grown).run(out);
}

void improve(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
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
  Crew crew(problem.model, options.threads, control);
  for (std::uint64_t tree = 1; best.iterations < options.max_iterations && !control.stop(); ++tree) {
    PlannerOptions next = options;
    next.seed = core::Random(options.seed, ~tree).bits();
    next.trees = 1;
    next.record_tree = false;
    next.max_iterations = static_cast<int>(std::min(patience, options.max_iterations - best.iterations));
    PlanResult found;
    TreeSearch search(problem, u_start, next, following, best.cost, crew, found);
    search.grow_to(next.max_iterations);
    core::run_lanes(crew.pool, 1, [&search](int, core::LaneTask* ended, long) { return ended == nullptr ? &search : nullptr; });
    add(search.counts(), best);
    if (found.status == Status::NumericalFailure) break;
    if (found.status != Status::Solved || found.cost >= best.cost) continue;
    best.plan = std::move(found.plan);
    best.cost = found.cost;
    best.improvements.push_back({found.cost, best.iterations, core::seconds_since(start)});
  }
  best.status = control.cancelled() ? Status::Cancelled : Status::Solved;
}

}  // namespace stiction::planning
