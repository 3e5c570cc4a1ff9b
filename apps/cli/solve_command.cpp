#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
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

/// Plans, refines, checks and simulates with one seed; stops early where nothing is left to gain.
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

  Try run(std::uint64_t seed, const core::RunControl& control, ProgressLine& line) {
    Try out;
    out.seed = seed;
    planning::PlannerOptions options = task_.options;
    options.seed = seed;
    if (arguments_.threads_given) options.threads = arguments_.threads;
    core::RunControl planning = control;
    planning.on_progress = [&line](const core::Progress& progress) { line.show(progress); };
    out.result.status = planning::plan(task_.problem, options, planning, out.result);
    out.plan_s = out.result.wall_s;
    if (out.solved()) {
      line.show(fmt::format("seed {}: refining", seed));
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
    line.show(fmt::format("seed {}: simulating", seed));
    simulate(control, out);
    return out;
  }

  /// Plan and timed commands.
  void write(const Try& t) const {
    tasks::write_plan(t.file, target_);
    if (t.solved())
      write_trajectory(target_.parent_path() / "trajectory.csv", t.file.joints,
                       execution::make_trajectory(*task_.model, t.result.plan, speed_limits(arguments_.speed)));
  }

 private:
  static int threads(const SolveArguments& a) { return a.threads_given && a.threads > 0 ? a.threads : core::hardware_threads(); }

  void simulate(const core::RunControl& control, Try& out) {
    const auto start = core::RunControl::Clock::now();
    execution::TransferOptions options;
    options.speed = speed_limits(arguments_.speed);
    options.alone = false;
    const auto run = [&](std::size_t k) {
      out.runs[k].status = execution::transfer(plants_[k], out.result.plan, options, control, out.runs[k]);
    };
    out.runs.resize(1);
    run(0);
    if (out.runs[0].reached) {  // most that miss do so here
      out.runs.resize(plants_.size());
      pool_.run(static_cast<int>(plants_.size()) - 1, [&](int k, int) { run(static_cast<std::size_t>(k) + 1); });
    }
    out.simulate_s = std::chrono::duration<double>(core::RunControl::Clock::now() - start).count();
  }

  const SolveArguments& arguments_;
  tasks::Task task_;
  fs::path target_;
  core::ThreadPool pool_;
  std::vector<std::shared_ptr<const simulation::Plant>> plants_;
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
                           {"duration_s", run.duration_s},
                           {"error", {{"position", run.error.position}, {"angle", run.error.angle}}}});
  }
  return out;
}

}  // namespace

int run_solve(const SolveArguments& arguments) {
  tasks::Task task = tasks::load_task(arguments.task, data_dirs());
  if (!arguments.goal.empty()) tasks::set_goal(task, parse_numbers("--goal", arguments.goal));
  const std::uint64_t first = arguments.seed_given ? arguments.seed : task.options.seed;
  const std::string name = task.name;
  const fs::path dir = arguments.out_dir.empty() ? fs::path(fmt::format("{}-solved", name)) : fs::path(arguments.out_dir);
  const fs::path target = dir / "plan.json";
  tasks::require_writable(dir);

  catch_signals();
  const auto start = core::RunControl::Clock::now();
  const core::RunControl control = make_run_control(arguments.timeout_s);
  Solver solver(arguments, std::move(task), target);
  fmt::print(stderr, "{}: a plan that reaches its goal in the second-order simulation\n", name);
  Try best;
  json tries = json::array();
  for (int k = 0; k < arguments.tries && !control.stop() && !best.holds(); ++k) {
    ProgressLine line;
    Try next = solver.run(first + static_cast<std::uint64_t>(k), control, line);
    line.clear();
    fmt::print(stderr, "{}\n", describe(arguments, next));
    tries.push_back(to_json(arguments, next));
    if (k > 0 && next.rank() <= best.rank()) continue;
    best = std::move(next);
    solver.write(best);
    if (!best.result.reason.empty()) break;  // the same for every seed
  }
  const bool cancelled = control.cancelled() && !best.holds();
  const std::string_view verdict = best.holds() ? "Held" : cancelled ? "Cancelled" : "NotHeld";
  const double wall_s = std::chrono::duration<double>(core::RunControl::Clock::now() - start).count();
  fmt::print(stderr, "  {} in {:.2f} s, {} of {} tries\n  {:22} {}\n", verdict, wall_s, tries.size(), arguments.tries, "plan",
             target.string());
  if (arguments.json) {
    json out;
    out["status"] = verdict;
    out["task"] = name;
    out["seed"] = best.seed;
    out["wall_s"] = wall_s;
    out["iterations"] = tries.size();
    out["tries"] = std::move(tries);
    out["plan"] = target.string();
    fmt::print("{}\n", out.dump());
  }
  return best.holds() ? kDone : cancelled ? kInterrupted : kNotSolved;
}

}  // namespace stiction::app
