#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "open_loop_speed.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/planning/refine.hpp"
#include "stiction/tasks/plan_file.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;
using core::Status;
using planning::RefineResult;

struct RefineArguments {
  std::string plan;
  std::string out_dir;
  std::optional<std::uint64_t> seed;
  std::optional<int> threads;
  double timeout_s = 20;
  double speed = execution::kOpenLoopSpeed;  ///< of trajectory.csv, times the full speed
  bool html = false;
  bool json = false;
};

void print_summary(std::FILE* to, const tasks::PlanFile& plan, const RefineResult& r, const execution::Trajectory& trajectory,
                   const fs::path& file) {
  const auto row = [to](std::string_view name, const std::string& value) { print_row(to, name, value); };
  say(to, "{}, seed {}: {}\n", plan.task_name, plan.seed, r.status == Status::Solved ? r.variant : std::string(core::to_string(r.status)));
  row("time", fmt::format("{:.3f} s", r.wall_s));
  row("pushes", fmt::format("{}, before {}", r.pushes, r.pushes_before));
  row("regrasps", fmt::format("{}, before {}; {} of them planned again", r.regrasps, r.regrasps_before, r.reconnected));
  row("sub-steps", fmt::format("{}, before {}", r.knots, r.knots_before));
  if (r.rest_planned_anew > 0) row("rest of the plan", fmt::format("planned again, with {} searches", r.rest_planned_anew));
  row("time step", fmt::format("{:.3g} s", r.plan.step.h));
  row("regrasp clearance", r.reconnected > 0 ? fmt::format("at least {:.1f} mm", 1e3 * r.least_clearance) : "–");
  row("error at the goal", fmt::format("{:.2f} mm (tolerance {:.0f}), {:.4f} rad (tolerance {:.2f})", 1e3 * r.plan.error.position,
                                       1e3 * plan.tol_position, r.plan.error.angle, plan.tol_angle));
  row("execution", fmt::format("{:.1f} s at {}", trajectory.duration(), describe_speed(trajectory.speed)));
  row("plan", file.string());
}

}  // namespace

void write_trajectory(const fs::path& file, const world::Model& model, const execution::Trajectory& trajectory) {
  std::string text = "time_s";
  const auto joints = model.dofs().last(static_cast<std::size_t>(model.n_a()));
  for (const auto& joint : joints) text += "," + joint.name;
  for (const auto& joint : joints) text += ",torque_" + joint.name;
  text += "\n";
  for (Eigen::Index k = 0; k < trajectory.times.size(); ++k) {
    const auto u = trajectory.u.col(k);
    const Eigen::VectorXd torque = model.stiffness().cwiseProduct(u - trajectory.q.col(k).tail(model.n_a()));
    text += fmt::format("{}", trajectory.times[k]);
    for (const double value : u) text += fmt::format(",{}", value);
    for (const double value : torque) text += fmt::format(",{}", value);
    text += "\n";
  }
  tasks::write_text(text, file);
}

namespace {

/// What --json prints.
nlohmann::ordered_json report(const tasks::PlanFile& file, const RefineResult& result, const execution::Trajectory& trajectory,
                              const fs::path& dir) {
  nlohmann::ordered_json out;
  out["status"] = core::to_string(result.status);
  out["task"] = file.task_name;
  out["seed"] = file.seed;
  out["wall_s"] = result.wall_s;
  out["steps"] = result.steps;
  out["failed_steps"] = result.failed_steps;
  out["variant"] = result.variant;
  out["h"] = result.plan.step.h;
  out["rest_planned_anew"] = result.rest_planned_anew;
  out["pushes"] = {{"before", result.pushes_before}, {"after", result.pushes}};
  out["regrasps"] = {{"before", result.regrasps_before}, {"after", result.regrasps}, {"planned_anew", result.reconnected}};
  out["knots"] = {{"before", result.knots_before}, {"after", result.knots}};
  out["least_clearance"] = result.least_clearance;
  out["error"] = {{"position", result.plan.error.position}, {"angle", result.plan.error.angle}};
  out["speed"] = trajectory.speed;
  out["duration_s"] = trajectory.duration();
  out["plan"] = (dir / "plan.json").string();
  out["trajectory"] = (dir / "trajectory.csv").string();
  return out;
}

int run_refine(const RefineArguments& arguments) {
  const core::RunControl control = make_run_control(arguments.timeout_s);  // what is read counts too
  const fs::path path = arguments.plan;
  const tasks::PlanFile file = tasks::read_plan(path);
  tasks::Task task = tasks::load_task_of_plan(file, path, data_dirs());
  if (file.status != Status::Solved)
    core::throw_invalid(path.string() + ": status", std::string(core::to_string(file.status)),
                        "Solved: a plan that reaches its goal; a longer search may find one (`stiction plan --timeout`)");
  planning::PlannerOptions options = tasks::options_of_plan(*task.model, file, path);
  options.threads = arguments.threads.value_or(0);
  const fs::path dir = arguments.out_dir.empty() ? plan_dir({}, path) / "refined" : fs::path(arguments.out_dir);
  tasks::require_writable(dir);

  catch_signals();
  planning::RefineOptions refine_options;
  refine_options.seed = arguments.seed.value_or(refine_options.seed);
  RefineResult result;
  const Status status = planning::refine(task.model, tasks::to_plan(*task.model, file), options, refine_options, control, result);

  planning::PlanResult refined = tasks::to_result(*task.model, file);  // the statistics stay those of the search
  refined.plan = result.plan;
  refined.wall_s += result.wall_s;
  task.start_from_command_line = file.start_from_command_line;
  task.goal_from_command_line = file.goal_from_command_line;
  task.options_from_command_line = file.options_from_command_line;
  const fs::path target = dir / "plan.json";
  tasks::write_plan(tasks::make_plan_file(task, options, refined, target), target);
  const execution::Trajectory trajectory = execution::make_trajectory(*task.model, result.plan, arguments.speed);
  write_trajectory(dir / "trajectory.csv", *task.model, trajectory);
  std::FILE* const to = people(arguments.json);
  print_summary(to, file, result, trajectory, target);

  const bool shown = arguments.html && status != Status::Cancelled;
  const bool page_failed = shown && !make_page(target, dir / "plan.html", to, "the plan itself is in " + target.string());
  if (arguments.json) say(stdout, "{}\n", report(file, result, trajectory, dir).dump());
  if (status == Status::Cancelled) return kInterrupted;
  if (status == Status::MaxIterations || status == Status::NumericalFailure) return kNotSolved;
  return page_failed ? kInternalError : kDone;
}

}  // namespace

Run declare_refine(CLI::App& command) {
  const auto arguments = std::make_shared<RefineArguments>();
  RefineArguments& a = *arguments;
  add_plan(command, a.plan);
  add_seed(command, a.seed, "Seed of the search for regrasp paths");
  add_timeout(command, a.timeout_s);
  add_threads(command, a.threads);
  add_open_loop_speed(command, a.speed);
  add_out(command, a.out_dir, "Folder for plan.json and trajectory.csv (default: `refined` in the folder of the plan)");
  command.add_flag("--html", a.html, "Also write plan.html, a page that plays the plan");
  add_json(command, a.json);
  return [arguments] { return run_refine(*arguments); };
}

}  // namespace stiction::app
