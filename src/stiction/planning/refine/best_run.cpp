#include "stiction/planning/refine/best_run.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace stiction::planning::refinement {
namespace {

/// Finished at once where it ends near enough.
void try_run(const Start& start, const Eigen::VectorXd& q_target, double enough, const Simulate& simulate, const Turn& turn,
             Scratch& scratch, Run& run) {
  if (stops(start.problem.control, &turn)) return;
  CommandFollower follower(start.problem, start.sizes, start.at.q, start.at.u, &turn, scratch);
  run.done = simulate(follower, run);
  run.end.q = std::move(follower.q);
  run.end.u = std::move(follower.u);
  run.work = follower.work;
  run.whole = start.problem.miss(q_target, run.end.q);
  if (run.done && run.whole <= enough) finish(start, q_target, scratch, run);
}

}  // namespace

void finish(const Start& start, const Eigen::VectorXd& q_target, Scratch& scratch, Run& run) {
  const Problem& problem = start.problem;
  run.end.fine = start.at.fine;
  run.holds = go_on_in_half_steps(problem.press, run.segments, start.sizes.exact, problem.allowed, problem.control, scratch, run.end.fine,
                                  run.work);
  run.missed = std::max(run.whole, problem.miss(q_target, run.end.fine.q));
}

std::optional<Run> best_of(const Start& start, std::vector<Run> runs, const Eigen::VectorXd& q_target, double enough,
                           const Simulate& simulate, Crew& crew, Work& work) {
  const auto stop = [&] { return stops(start.problem.control, start.turn); };
  const auto near_enough = [enough](const Run& run) { return run.holds && run.missed <= enough; };
  std::optional<Run> best;
  std::vector<Run*> later;
  const int n = static_cast<int>(runs.size());
  const int tried = crew.pool.run_until(
      n,
      [&](int item, int worker, const Turn& turn) {
        Run& run = runs[static_cast<std::size_t>(item)];
        try_run(start, q_target, enough, simulate, turn, crew.of(worker), run);
        return near_enough(run) ? item + 1 : n;
      },
      start.turn);
  if (stop()) return best;
  const auto look_at = [&](Run& run) {
    work += run.work;
    if (run.way != nullptr && !std::exchange(run.way->counted, true)) work += run.way->work;
    if (run.holds && (!best || run.missed < best->missed)) best = std::move(run);
  };
  for (Run& run : std::span(runs).first(static_cast<std::size_t>(tried))) {
    if (run.done && run.whole > enough) later.push_back(&run);
    look_at(run);
  }
  if (best && best->missed <= enough) return best;
  std::stable_sort(later.begin(), later.end(), [](const Run* a, const Run* b) { return a->whole < b->whole; });
  // At half sub-steps a run ends no nearer than at whole ones.
  const auto needed = [&later](double missed) {
    const auto farther = std::find_if(later.begin(), later.end(), [&](const Run* run) { return missed <= run->whole + kSamePlace; });
    return static_cast<int>(farther - later.begin());
  };
  const int finished = crew.pool.run_until(
      best ? needed(best->missed) : static_cast<int>(later.size()),
      [&](int item, int worker, const Turn&) {
        Run& run = *later[static_cast<std::size_t>(item)];
        finish(start, q_target, crew.of(worker), run);
        return run.holds ? std::max(item + 1, needed(run.missed)) : static_cast<int>(later.size());
      },
      start.turn);
  if (stop()) return best;
  for (Run* run : std::span(later).first(static_cast<std::size_t>(finished))) look_at(*run);
  return best;
}

}  // namespace stiction::planning::refinement
