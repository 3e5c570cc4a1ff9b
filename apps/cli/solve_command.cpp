#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "open_loop_speed.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/tasks/lint.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/solve.hpp"
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
  double timeout_s = 120;                    ///< of all tries
  std::vector<double> friction = {1.0};      ///< the goal has to be reached with every μ times each of these
  double speed = execution::kOpenLoopSpeed;  ///< times the full speed
  std::optional<int> threads;
  std::string out_dir;
  bool json = false;
};

std::string describe(const tasks::SolveTry& t) {
  std::string out = fmt::format("  seed {:<5} plan {:.2f} s", t.seed, t.plan_s);
  if (!t.solved())
    return fmt::format("{}: {}{}{}", out, core::to_string(t.result.status), t.result.reason.empty() ? "" : ": ", t.result.reason);
  out += fmt::format(", refine {:.2f} s, {}", t.refine_s, t.accepted ? "accepted" : "not accepted");
  if (t.runs.empty()) return out;
  out += fmt::format(", simulate {:.2f} s", t.simulate_s);
  for (const auto& run : t.runs) {
    out += fmt::format("; friction × {:g}: {}", run.friction,
                       run.reached   ? "goal reached"
                       : run.dropped ? "object dropped"
                       : run.lost    ? fmt::format("object far off its path after {:.1f} s", run.duration_s)
                       : run.status != Status::Solved
                           ? std::string(core::to_string(run.status))
                           : fmt::format("missed by {:.1f} mm, {:.2f} rad", 1e3 * run.error.position, run.error.angle));
  }
  return out;
}

json to_json(const tasks::SolveTry& t) {
  json out;
  out["seed"] = t.seed;
  out["planned"] = t.solved();
  out["accepted"] = t.accepted;
  out["plan_s"] = t.plan_s;
  out["refine_s"] = t.refine_s;
  out["simulate_s"] = t.simulate_s;
  out["runs"] = json::array();
  for (const auto& run : t.runs) {
    out["runs"].push_back({{"friction", run.friction},
                           {"reached", run.reached},
                           {"dropped", run.dropped},
                           {"lost", run.lost},
                           {"duration_s", run.duration_s},
                           {"error", {{"position", run.error.position}, {"angle", run.error.angle}}}});
  }
  return out;
}

/// The plan and its timed commands.
void write(const tasks::Task& task, const tasks::SolveTry& t, double speed, const fs::path& target) {
  planning::PlannerOptions options = task.options;
  options.seed = t.seed;
  const tasks::PlanFile file = tasks::make_plan_file(task, options, t.result, target);
  tasks::write_plan(file, target);
  if (t.solved())
    write_trajectory(target.parent_path() / "trajectory.csv", *task.model, execution::make_trajectory(*task.model, t.result.plan, speed));
}

void show(ProgressLine& line, std::uint64_t seed, tasks::SolveStage stage, const core::Progress& progress) {
  switch (stage) {
    case tasks::SolveStage::Plan:
      return line.show(fmt::format("seed {}: {:.1f} s, {:.3g} tolerances from the goal", seed, progress.elapsed_s, progress.best));
    case tasks::SolveStage::Refine:
      return line.show(fmt::format("seed {}: refining", seed));
    case tasks::SolveStage::Simulate:
      return line.show(fmt::format("seed {}: simulating", seed));
  }
}

int run_solve(const SolveArguments& arguments) {
  const core::RunControl control = make_run_control(arguments.timeout_s);  // what is read counts too
  tasks::Task task = tasks::load_task(arguments.task, data_dirs());
  print_notes(task);
  if (!arguments.goal.empty()) tasks::set_goal(task, parse_numbers("--goal", arguments.goal));
  ProgressLine line;
  std::FILE* const to = people(arguments.json);
  tasks::SolveOptions options;
  options.seed = arguments.seed.value_or(task.options.seed);
  options.tries = arguments.tries;
  options.friction = arguments.friction;
  options.speed = arguments.speed;
  options.threads = arguments.threads.value_or(0);
  const fs::path target = task_dir(arguments.out_dir, task.name, options.seed) / "plan.json";
  options.on_stage = [&](std::uint64_t seed, tasks::SolveStage stage, const core::Progress& progress) {
    show(line, seed, stage, progress);
  };
  options.on_try = [&](const tasks::SolveTry& ended, bool best) {
    line.clear();
    if (best) write(task, ended, options.speed, target);
    say(to, "{}\n", describe(ended));
    flush_text(to);
  };
  options.validate();
  tasks::require_writable(target.parent_path());
  print_warnings(tasks::lint(task, control));

  catch_signals();
  say(to, "{}: a plan that reaches its goal in the second-order simulation\n", task.name);
  tasks::SolveResult result;
  const Status status = tasks::solve(task, options, control, result);
  line.clear();
  const std::string_view verdict = status == Status::Solved ? "Held" : status == Status::Cancelled ? "Cancelled" : "NotHeld";
  const std::string_view words = status == Status::Solved      ? "found"
                                 : status == Status::Cancelled ? "interrupted"
                                                               : "goal not reached";
  say(to, "  {} after {:.2f} s and {} of at most {} tries\n", words, result.wall_s, result.tries.size(), arguments.tries);
  print_row(to, "speed", describe_speed(options.speed));
  print_row(to, "plan", target.string());
  if (arguments.json) {
    json out;
    out["status"] = verdict;
    out["task"] = task.name;
    out["seed"] = result.best.seed;
    out["wall_s"] = result.wall_s;
    out["speed"] = options.speed;
    out["tries"] = json::array();
    for (const auto& t : result.tries) out["tries"].push_back(to_json(t));
    out["plan"] = target.string();
    say(stdout, "{}\n", out.dump());
  }
  return status == Status::Solved ? kDone : status == Status::Cancelled ? kInterrupted : kNotSolved;
}

}  // namespace

Run declare_solve(CLI::App& command) {
  const auto arguments = std::make_shared<SolveArguments>();
  SolveArguments& a = *arguments;
  add_task(command, a.task);
  add_seed(command, a.seed, "Seed of the first try");
  add_goal(command, a.goal);
  add_integer(command, "--tries", a.tries, "Largest number of seeds to try", {1, 1000000});
  add_timeout(command, a.timeout_s, "Wall-clock budget of all tries [s]");
  add_numbers(command, "--friction", a.friction,
              "Factors on every coefficient of friction in the simulation; the plan must reach its goal with each factor",
              Bound::NonNegative);
  add_open_loop_speed(command, a.speed);
  add_threads(command, a.threads);
  add_out(command, a.out_dir, "Folder for plan.json and trajectory.csv (default ./TASK-seedN with the seed of the first try)");
  add_json(command, a.json);
  return [arguments] { return run_solve(*arguments); };
}

}  // namespace stiction::app
