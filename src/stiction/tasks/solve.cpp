#include "stiction/tasks/solve.hpp"

#include <algorithm>
#include <map>
#include <mutex>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/execution/open_loop/transfer.hpp"
#include "stiction/planning/refine.hpp"
#include "stiction/tasks/check.hpp"
#include "stiction/tasks/plan_file.hpp"

namespace stiction::tasks {
namespace {

using core::RunControl;
using core::Status;
using Turn = core::ThreadPool::Turn;

class Solver {
 public:
  Solver(const Task& task, const SolveOptions& options)
      : task_(task), options_(options), pool_(options.threads > 0 ? options.threads : core::hardware_threads()) {
    for (const double friction : options.friction) {
      simulation::PlantOptions plant;
      plant.rest_time = execution::kRestTime;
      plant.velocity_reference = true;
      plant.effort_limits = true;
      plant.contact.friction_scale = friction;
      plants_.push_back(simulation::Plant::make(task.model, plant));
    }
  }

  void run(const RunControl& control, SolveResult& out) {
    const int counted = pool_.run_until(options_.tries, [&](int k, int, const Turn& turn) {
      if (k > 0 && control.stop()) return options_.tries;  // the first try at least gives the reason why there is no plan
      RunControl own = control;
      own.abandoned = [&turn, &control] { return turn.over() || (control.abandoned && control.abandoned()); };
      SolveTry next = attempt(options_.seed + static_cast<std::uint64_t>(k), own, turn);
      const bool last = next.holds() || !next.result.reason.empty();  // a reason is the same for every seed
      if (!turn.over()) take(k, std::move(next));
      return last ? k + 1 : options_.tries;
    });
    for (auto& [k, ended] : tries_) {
      if (k < counted) out.tries.push_back(std::move(ended));
    }
    out.best = std::move(best_);
  }

 private:
  SolveTry attempt(std::uint64_t seed, const RunControl& control, const Turn& turn) {
    SolveTry out;
    out.seed = seed;
    planning::PlannerOptions options = task_.options;
    options.seed = seed;
    options.threads = std::max(1, pool_.size() / options_.tries);  // the plan does not depend on the number of threads
    RunControl planning = control;
    planning.on_progress = [&](const core::Progress& progress) { tell(seed, SolveStage::Plan, progress); };
    out.result.status = planning::plan(task_.problem, options, planning, out.result);
    out.plan_s = out.result.wall_s;
    if (!out.solved()) return out;
    tell(seed, SolveStage::Refine, {});
    planning::RefineResult refined;
    if (planning::refine(task_.model, out.result.plan, options, {}, control, refined) == Status::Solved)
      out.result.plan = std::move(refined.plan);
    out.result.wall_s += refined.wall_s;
    out.refine_s = refined.wall_s;
    if (control.stop()) return out;
    CheckReport report;
    const PlanFile file = make_plan_file(task_, options, out.result, "plan.json");
    out.accepted = check_plan(task_, file, {}, control, report) == Status::Solved && report.pass;
    if (!out.accepted || control.stop()) return out;
    tell(seed, SolveStage::Simulate, {});
    simulate(control, turn, out);
    return out;
  }

  void simulate(const RunControl& control, const Turn& turn, SolveTry& out) {
    const auto start = RunControl::Clock::now();
    execution::TransferOptions options;
    options.speed = options_.speed;
    options.alone = false;
    options.lost_factor = options_.lost_factor;
    const auto run = [&](int k) {
      const auto i = static_cast<std::size_t>(k);
      execution::TransferResult result;
      const Status status = execution::transfer(plants_[i], out.result.plan, options, control, result);
      out.runs[i] = {options_.friction[i], status,      result.reached, result.dropped.has_value(), result.lost,
                     result.duration_s,    result.error};
    };
    out.runs.resize(1);
    run(0);
    if (out.runs[0].reached) {  // most failing plans miss the goal in this first run
      const int n = static_cast<int>(plants_.size());
      out.runs.resize(plants_.size());
      const auto body = [&](int k, int, const Turn&) {
        run(k + 1);
        return n - 1;
      };
      pool_.run_until(n - 1, body, &turn);
    }
    out.simulate_s = core::seconds_since(start);
  }

  void take(int k, SolveTry next) {
    const std::lock_guard lock(mutex_);
    const bool best = tries_.empty() || next.better_than(best_);
    if (options_.on_try) options_.on_try(next, best);
    SolveTry& kept = tries_[k];
    if (best) {
      kept = next;
      best_ = std::move(next);
    } else {
      kept = std::move(next);
    }
    kept.result.tree.clear();
  }

  void tell(std::uint64_t seed, SolveStage stage, const core::Progress& progress) {
    if (!options_.on_stage) return;
    const std::lock_guard lock(mutex_);
    options_.on_stage(seed, stage, progress);
  }

  const Task& task_;
  const SolveOptions& options_;
  core::ThreadPool pool_;
  std::vector<std::shared_ptr<const simulation::Plant>> plants_;
  std::mutex mutex_;  ///< protects the members below, and the callbacks
  std::map<int, SolveTry> tries_;
  SolveTry best_;
};

}  // namespace

long SolveTry::reached() const {
  return std::count_if(runs.begin(), runs.end(), [](const SolveRun& run) { return run.reached; });
}

bool SolveTry::better_than(const SolveTry& other) const {
  const auto rank = [](const SolveTry& t) { return std::tuple(t.solved(), t.accepted, t.reached()); };
  return rank(*this) != rank(other) ? rank(*this) > rank(other) : seed < other.seed;
}

void SolveOptions::validate() const {
  if (tries < 1) core::throw_invalid("tries", std::to_string(tries), "a number ≥ 1");
  if (friction.empty()) core::throw_invalid("friction", "no number", "at least one");
  for (const double x : friction) core::require_nonnegative("friction", x);
  core::require_positive("lost_factor", lost_factor);
  if (threads < 0) core::throw_invalid("threads", std::to_string(threads), "a number ≥ 0");
  core::require_positive("speed", speed);
}

Status solve(const Task& task, const SolveOptions& options, const RunControl& control, SolveResult& out) {
  const auto start = RunControl::Clock::now();
  options.validate();
  out = {};
  Solver(task, options).run(control, out);
  out.wall_s = core::seconds_since(start);
  out.status = out.best.holds() ? Status::Solved : control.status_when_stopped();
  return out.status;
}

}  // namespace stiction::tasks
