#include "stiction/planning/anytime.hpp"

#include <algorithm>

#include "stiction/core/random.hpp"

namespace stiction::planning {
namespace {

using core::Status;

/// Extensions after which the search for a cheaper path turns to the next tree, as a multiple of those of the first solution …
constexpr long kPatience = 4;
constexpr long kLeastPatience = 1000;  ///< … or so many

}  // namespace

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
    run_lanes(crew.pool, 1, [&search](int, TreeTask* ended, long) { return ended == nullptr ? &search : nullptr; });
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
