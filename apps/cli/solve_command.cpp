#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/execution/transfer.hpp"
#include "stiction/planning/refine.hpp"
#include "stiction/tasks/check.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;
using core::Status;
using json = nlohmann::ordered_json;

struct SolveArguments {
  std::string task;
  std::optional<std::uint64_t> seed;  ///< of the first try; the next ones count up
  std::string goal;
  int tries = 20;
  double timeout_s = 120;                ///< of all tries
  std::vector<double> friction = {1.0};  ///< the goal has to be reached with every μ times each of these
  double speed = 1;                      ///< times the default speeds
  std::optional<int> threads;
  std::string out_dir;
  bool json = false;
};

/// Of the tolerances: an object that is farther from where the plan has it does not come back.
constexpr double kLost = 5;

/// One seed: a refined plan and how far it came.
struct Try {
  std::uint64_t seed = 0;
  planning::PlanResult result;  ///< of the search, with the refined plan
  tasks::PlanFile file;
  bool accepted = false;  ///< by the checker
  std::vector<execution::TransferResult> runs;
  double plan_s = 0, refine_s = 0, simulate_s = 0;

  bool solved() const { return result.status == Status::Solved; }
  long reached() const {
    return std::count_if(runs.begin(), runs.end(), [](const auto& run) { return run.reached; });
  }
  bool holds() const { return !runs.empty() && reached() == std::ssize(runs); }
  /// Of two that do not hold, the better one: solved, accepted, reached the goal more often.
  auto rank() const { return std::tuple(solved(), accepted, reached()); }
};

std::string describe(const SolveArguments& arguments, const Try& t) {
  std::string out = fmt::format("  seed {:<5} plan {:.2f} s", t.seed, t.plan_s);
  if (!t.solved())
    return fmt::format("{}: {}{}{}", out, core::to_string(t.result.status), t.result.reason.empty() ? "" : ": ", t.result.reason);
  out += fmt::format(", refine {:.2f} s, {}", t.refine_s, t.accepted ? "accepted" : "not accepted");
  if (t.runs.empty()) return out;
  out += fmt::format(", simulate {:.2f} s", t.simulate_s);
  for (std::size_t i = 0; i < t.runs.size(); ++i) {
    const auto& run = t.runs[i];
    out += fmt::format("; friction × {:g}: {}", arguments.friction[i],
                       run.reached   ? "goal reached"
                       : run.dropped ? "dropped"
                       : run.lost    ? fmt::format("lost after {:.1f} s", run.duration_s)
                       : run.status != Status::Solved
                           ? std::string(core::to_string(run.status))
                           : fmt::format("missed by {:.1f} mm, {:.2f} rad", 1e3 * run.error.position, run.error.angle));
  }
  return out;
}

json to_json(const SolveArguments& arguments, const Try& t) {
  json out;
  out["seed"] = t.seed;
  out["planned"] = t.solved();
  out["accepted"] = t.accepted;
  out["plan_s"] = t.plan_s;
  out["refine_s"] = t.refine_s;
  out["simulate_s"] = t.simulate_s;
  out["runs"] = json::array();
  for (std::size_t i = 0; i < t.runs.size(); ++i) {
    const auto& run = t.runs[i];
    out["runs"].push_back({{"friction", arguments.friction[i]},
                           {"reached", run.reached},
                           {"dropped", run.dropped.has_value()},
                           {"lost", run.lost},
                           {"duration_s", run.duration_s},
                           {"error", {{"position", run.error.position}, {"angle", run.error.angle}}}});
  }
  return out;
}

/// Plans, refines, checks and simulates seeds side by side; the first in order that holds counts.
class Solver {
 public:
  Solver(const SolveArguments& arguments, tasks::Task task, const fs::path& target)
      : arguments_(arguments), task_(std::move(task)), target_(target), pool_(threads(arguments)) {
    for (const double friction : arguments.friction) {
      simulation::PlantOptions options;
      options.rest_time = planning::kRestTime;
      options.velocity_reference = true;
      options.contact.friction_scale = friction;
      plants_.push_back(simulation::Plant::make(task_.model, options));
    }
  }

  /// The best try, as it was written. @param first  seed of the first try   @param tries  what became of each that counts, in order
  Try run(std::uint64_t first, const core::RunControl& control, json& tries) {
    const int counted = pool_.run_until(arguments_.tries, [&](int k, int, const core::ThreadPool::Turn& turn) {
      if (k > 0 && control.stop()) return arguments_.tries;  // the first says at least why there is no plan
      core::RunControl own = control;
      own.abandoned = [&turn] { return turn.over(); };
      Try next = attempt(first + static_cast<std::uint64_t>(k), own, turn);
      const bool last = next.holds() || !next.result.reason.empty();  // a reason is the same for every seed
      if (!turn.over()) take(k, std::move(next));
      return last ? k + 1 : arguments_.tries;
    });
    line_.clear();
    tries = json::array();
    for (const auto& [k, row] : rows_) {
      if (k < counted) tries.push_back(row);
    }
    return std::move(best_);
  }

 private:
  static int threads(const SolveArguments& a) { return a.threads.value_or(0) > 0 ? *a.threads : core::hardware_threads(); }

  Try attempt(std::uint64_t seed, const core::RunControl& control, const core::ThreadPool::Turn& turn) {
    Try out;
    out.seed = seed;
    planning::PlannerOptions options = task_.options;
    options.seed = seed;
    options.threads = std::max(1, pool_.size() / arguments_.tries);  // the plan does not depend on it
    core::RunControl planning = control;
    planning.on_progress = [&](const core::Progress& progress) {
      show(fmt::format("seed {}: {:.1f} s, {:.3g} tolerances from the goal", seed, progress.elapsed_s, progress.best));
    };
    out.result.status = planning::plan(task_.problem, options, planning, out.result);
    out.plan_s = out.result.wall_s;
    if (out.solved()) {
      show(fmt::format("seed {}: refining", seed));
      planning::RefineResult refined;
      if (planning::refine(task_.model, out.result.plan, options, {}, control, refined) == Status::Solved)
        out.result.plan = std::move(refined.plan);
      out.result.wall_s += refined.wall_s;
      out.refine_s = refined.wall_s;
    }
    out.file = tasks::make_plan_file(task_, options, out.result, target_);
    if (!out.solved() || control.stop()) return out;
    tasks::CheckReport report;
    out.accepted = tasks::check_plan(task_, out.file, {}, control, report) == Status::Solved && report.pass;
    if (!out.accepted || control.stop()) return out;
    show(fmt::format("seed {}: simulating", seed));
    simulate(control, turn, out);
    return out;
  }

  void simulate(const core::RunControl& control, const core::ThreadPool::Turn& turn, Try& out) {
    const auto start = core::RunControl::Clock::now();
    execution::TransferOptions options;
    options.speed = speed_limits(arguments_.speed);
    options.alone = false;
    options.lost_factor = kLost;
    const auto run = [&](int k) {
      auto& result = out.runs[static_cast<std::size_t>(k)];
      result.status = execution::transfer(plants_[static_cast<std::size_t>(k)], out.result.plan, options, control, result);
    };
    out.runs.resize(1);
    run(0);
    if (out.runs[0].reached) {  // most that miss do so here
      const int n = static_cast<int>(plants_.size());
      out.runs.resize(plants_.size());
      const auto body = [&](int k, int, const core::ThreadPool::Turn&) {
        run(k + 1);
        return n - 1;
      };
      pool_.run_until(n - 1, body, &turn);
    }
    out.simulate_s = std::chrono::duration<double>(core::RunControl::Clock::now() - start).count();
  }

  /// Says what became of a try, and writes it where it is the best one so far: plan and timed commands.
  void take(int k, Try next) {
    const std::lock_guard lock(mutex_);
    line_.clear();
    fmt::print(people(arguments_.json), "{}\n", describe(arguments_, next));
    rows_[k] = to_json(arguments_, next);
    if (rows_.size() > 1 && (next.rank() < best_.rank() || (next.rank() == best_.rank() && next.seed > best_.seed))) return;
    best_ = std::move(next);
    tasks::write_plan(best_.file, target_);
    if (best_.solved())
      write_trajectory(target_.parent_path() / "trajectory.csv", best_.file.joints,
                       planning::make_trajectory(*task_.model, best_.result.plan, speed_limits(arguments_.speed)));
  }

  void show(const std::string& text) {
    const std::lock_guard lock(mutex_);
    line_.show(text);
  }

  const SolveArguments& arguments_;
  tasks::Task task_;
  fs::path target_;
  core::ThreadPool pool_;
  std::vector<std::shared_ptr<const simulation::Plant>> plants_;
  std::mutex mutex_;  ///< of what follows
  ProgressLine line_;
  std::map<int, json> rows_;  ///< per try that ended
  Try best_;
};

int run_solve(const SolveArguments& arguments) {
  tasks::Task task = tasks::load_task(arguments.task, data_dirs());
  if (!arguments.goal.empty()) tasks::set_goal(task, parse_numbers("--goal", arguments.goal));
  const std::uint64_t first = arguments.seed.value_or(task.options.seed);
  const std::string name = task.name;
  const fs::path dir = task_dir(arguments.out_dir, name, first);
  const fs::path target = dir / "plan.json";
  tasks::require_writable(dir);

  catch_signals();
  const auto start = core::RunControl::Clock::now();
  const core::RunControl control = make_run_control(arguments.timeout_s);
  Solver solver(arguments, std::move(task), target);
  std::FILE* const to = people(arguments.json);
  fmt::print(to, "{}: a plan that reaches its goal in the second-order simulation\n", name);
  json tries;
  const Try best = solver.run(first, control, tries);
  const bool cancelled = control.cancelled() && !best.holds();
  const std::string_view verdict = best.holds() ? "Held" : cancelled ? "Cancelled" : "NotHeld";
  const double wall_s = std::chrono::duration<double>(core::RunControl::Clock::now() - start).count();
  fmt::print(to, "  {} in {:.2f} s, {} of {} tries\n  {:22} {}\n", verdict, wall_s, tries.size(), arguments.tries, "plan", target.string());
  if (arguments.json) {
    json out;
    out["status"] = verdict;
    out["task"] = name;
    out["seed"] = best.seed;
    out["wall_s"] = wall_s;
    out["tries"] = std::move(tries);
    out["plan"] = target.string();
    fmt::print("{}\n", out.dump());
  }
  return best.holds() ? kDone : cancelled ? kInterrupted : kNotSolved;
}

}  // namespace

Run declare_solve(CLI::App& command) {
  const auto arguments = std::make_shared<SolveArguments>();
  SolveArguments& a = *arguments;
  add_task(command, a.task);
  add_seed(command, a.seed, "Seed of the first try");
  add_goal(command, a.goal);
  command.add_option("--tries", a.tries, "Seeds that are tried")->capture_default_str()->check(CLI::Range(1, 1000000));
  add_timeout(command, a.timeout_s, "Wall-clock budget of all tries [s]");
  command.add_option("--friction", a.friction, "The goal has to be reached with every coefficient of friction times each of these numbers")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  add_speed(command, a.speed);
  add_threads(command, a.threads);
  add_out(command, a.out_dir, "Folder for plan.json and trajectory.csv (default ./TASK-seedN, N of the first try)");
  add_json(command, a.json);
  return [arguments] { return run_solve(*arguments); };
}

}  // namespace stiction::app
