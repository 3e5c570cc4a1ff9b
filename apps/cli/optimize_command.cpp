#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/trajopt/optimize.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;
using core::Status;
using trajopt::OptimizeResult;

struct OptimizeArguments {
  std::string task;
  std::string scheme;  ///< empty: that of the task
  std::string solver;  ///< the same
  bool forces = false;
  std::optional<std::uint64_t> seed;
  std::optional<int> iterations;  ///< nothing: those of the task
  double timeout_s = 60;
  std::optional<int> threads;
  std::string out_dir;
  bool json = false;
};

/// The trajectory as a plan of single steps, for `view` and `check`.
planning::PlanResult as_plan(const tasks::Task& task, const OptimizeResult& r, std::uint64_t seed) {
  planning::PlanResult out;
  planning::Plan& plan = out.plan;
  plan.q_start = task.problem.q_start;
  plan.u_start = plan.q_start.tail(task.model->n_a());
  plan.goal = task.problem.goal;
  plan.step = task.optimize->options.step;
  plan.step.smoothing = dynamics::Exact{};
  auto& segment = plan.segments.emplace_back();
  for (std::size_t t = 0; t < r.u.size(); ++t) segment.knots.push_back({r.u[t], r.q[t + 1], r.contacts[t]});
  plan.error = planning::goal_error(*task.model, r.q.empty() ? plan.q_start : r.q.back(), plan.goal);
  out.status = r.status == Status::Solved && !plan.error.within(plan.goal) ? Status::MaxIterations : r.status;
  out.seed = seed;
  out.iterations = static_cast<long>(r.history.size()) - 1;
  out.steps = r.steps;
  out.linearisations = r.linearisations;
  out.wall_s = r.wall_s;
  return out;
}

nlohmann::ordered_json terms_json(const trajopt::CostTerms& c) {
  return {{"total", c.total()}, {"objects", c.objects},           {"objects_final", c.objects_final},
          {"robots", c.robots}, {"robots_final", c.robots_final}, {"input", c.input}};
}

nlohmann::ordered_json to_json(const tasks::Task& task, const OptimizeResult& r, const planning::PlanResult& plan, const fs::path& file) {
  nlohmann::ordered_json out;
  out["status"] = core::to_string(r.status);
  out["task"] = task.name;
  out["scheme"] = tasks::kSchemeNames[static_cast<std::size_t>(task.optimize->scheme)];
  out["seed"] = plan.seed;
  out["wall_s"] = r.wall_s;
  out["iterations"] = r.history.empty() ? 0 : r.history.size() - 1;
  out["cost"] = terms_json(r.cost);
  out["error"] = {{"position", plan.plan.error.position}, {"angle", plan.plan.error.angle}};
  out["tolerance"] = {{"position", plan.plan.goal.tol_position}, {"angle", plan.plan.goal.tol_angle}};
  out["steps"] = r.steps;
  out["linearisations"] = r.linearisations;
  out["history"] = nlohmann::ordered_json::array();
  for (const auto& entry : r.history) {
    out["history"].push_back({{"cost", terms_json(entry.cost)},
                              {"best", entry.best},
                              {"predicted", entry.predicted},
                              {"length", entry.length},
                              {"sharpness", entry.sharpness},
                              {"qp_iterations", entry.qp_iterations},
                              {"failed_models", entry.failed_models},
                              {"elapsed_s", entry.elapsed_s}});
  }
  out["options"] = nlohmann::ordered_json::parse(tasks::optimize_setup_json(*task.optimize));
  out["plan"] = file.string();
  return out;
}

void print_summary(std::FILE* to, const tasks::Task& task, const OptimizeResult& r, const planning::PlanResult& plan,
                   const fs::path& file) {
  const auto row = [to](std::string_view name, const std::string& value) { print_row(to, name, value); };
  say(to, "{}, {}: {}\n", task.name, tasks::kSchemeNames[static_cast<std::size_t>(task.optimize->scheme)],
      r.status == Status::Solved ? "done" : std::string(core::to_string(r.status)));
  row("time", fmt::format("{:.3f} s", r.wall_s));
  if (r.history.empty()) return;
  row("cost",
      fmt::format("{:.4g} after {} iterations, {:.4g} at the start", r.cost.total(), r.history.size() - 1, r.history[0].cost.total()));
  row("parts of the cost", fmt::format("objects {:.4g} on the way, {:.4g} at the end; robots {:.4g}; input {:.4g}", r.cost.objects,
                                       r.cost.objects_final, r.cost.robots + r.cost.robots_final, r.cost.input));
  row("error at the goal", fmt::format("{:.2f} mm (tolerance {:.0f}), {:.4f} rad (tolerance {:.2f})", 1e3 * plan.plan.error.position,
                                       1e3 * plan.plan.goal.tol_position, plan.plan.error.angle, plan.plan.goal.tol_angle));
  row("work", fmt::format("{} simulation steps, {} local models", r.steps, r.linearisations));
  row("plan", file.string());
}

int run_optimize(const OptimizeArguments& arguments) {
  tasks::Task task = tasks::load_task(arguments.task, data_dirs());
  print_notes(task);
  if (!task.optimize) core::throw_invalid("task", fmt::format("'{}', which has no section 'optimize'", task.name), "a task with one");
  tasks::OptimizeSetup& setup = *task.optimize;
  if (!arguments.scheme.empty()) setup.choose(tasks::parse_scheme("--scheme", arguments.scheme));
  if (!arguments.solver.empty()) setup.options.solver = tasks::parse_solver("--solver", arguments.solver);
  if (arguments.forces && !setup.options.forces) setup.options.forces.emplace();
  if (arguments.seed) setup.set_seed(*arguments.seed);
  setup.options.iterations = arguments.iterations.value_or(setup.options.iterations);
  setup.options.threads = arguments.threads.value_or(setup.options.threads);
  setup.options.validate(*task.model);
  const fs::path dir = task_dir(arguments.out_dir, task.name, setup.randomized_first.seed);
  const fs::path file = dir / "plan.json";
  tasks::require_writable(dir);

  catch_signals();
  ProgressLine line;
  core::RunControl control = make_run_control(arguments.timeout_s);
  control.on_progress = [&](const core::Progress& p) {
    line.show(fmt::format("{:6.1f} s   iteration {} of {}   cost {:.4g}", p.elapsed_s, p.iteration, setup.options.iterations, p.best));
  };

  trajopt::OptimizeWorkspace work(task.model, setup.options.threads);
  OptimizeResult result;
  const auto input = tasks::make_optimize_input(task);
  const Status status = trajopt::optimize(*task.model, input, setup.options, control, work, result);
  line.clear();
  const auto plan = as_plan(task, result, setup.randomized_first.seed);
  planning::PlannerOptions options = task.options;
  if (!options.thesis) options.thesis.emplace();
  options.thesis->h = setup.options.step.h;
  options.thesis->regularisation = setup.options.step.regularisation;
  tasks::write_plan(tasks::make_plan_file(task, options, plan, file), file);
  const auto json = to_json(task, result, plan, file);
  tasks::write_text(json.dump(1) + "\n", dir / "optimize.json");
  print_summary(people(arguments.json), task, result, plan, file);
  if (arguments.json) say(stdout, "{}\n", json.dump());
  if (status == Status::Cancelled) return kInterrupted;
  return status == Status::Solved ? kDone : kNotSolved;
}

}  // namespace

Run declare_optimize(CLI::App& command) {
  const auto arguments = std::make_shared<OptimizeArguments>();
  OptimizeArguments& a = *arguments;
  command.add_option("task", a.task, "Name of a built-in task, or a task file (.yaml), with a section 'optimize'")->required();
  add_scheme(command, a.scheme);
  command.add_option("--solver", a.solver,
                     "Solver: sweep (one QP per iteration) or receding (Alg. 1 of the thesis as published) (default: as in the task)");
  command.add_flag("--forces", a.forces, "Use a contact trust region: linearised contact forces stay in their friction cones");
  add_seed(command, a.seed, "Seed of the randomized schemes");
  add_integer(command, "--iterations", a.iterations, "Largest number of iterations (default: as in the task)", {1, 1000000});
  add_timeout(command, a.timeout_s);
  add_threads(command, a.threads);
  add_out(command, a.out_dir, "Folder for plan.json and optimize.json (default ./TASK-seedN)");
  add_json(command, a.json);
  return [arguments] { return run_optimize(*arguments); };
}

}  // namespace stiction::app
