#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/refine.hpp"
#include "stiction/planning/trajectory.hpp"
#include "stiction/tasks/plan_file.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;
using core::Status;
using planning::RefineResult;

void print_summary(const tasks::PlanFile& plan, const RefineResult& r, double duration_s, const fs::path& file) {
  const auto row = [](std::string_view name, const std::string& value) { fmt::print(stderr, "  {:22} {}\n", name, value); };
  fmt::print(stderr, "{}, seed {}: {}\n", plan.task_name, plan.seed,
             r.status == Status::Solved ? r.variant : std::string(core::to_string(r.status)));
  row("time", fmt::format("{:.3f} s", r.wall_s));
  row("pushes", fmt::format("{} of {}", r.pushes, r.pushes_before));
  row("regrasps", fmt::format("{} of {}, {} planned anew", r.regrasps, r.regrasps_before, r.reconnected));
  row("sub-steps", fmt::format("{} of {}", r.knots, r.knots_before));
  row("pushes led back", fmt::format("{} of {} by feedback, {} by iMPC", r.led, r.pushes, r.corrected));
  row("time step", fmt::format("{:.3g} s", r.plan.step.h));
  row("clearance", r.reconnected > 0 ? fmt::format("at least {:.1f} mm", 1e3 * r.least_clearance) : "–");
  row("error at the goal", fmt::format("{:.2f} mm of {:.0f}, {:.4f} rad of {:.2f}", 1e3 * r.plan.error.position, 1e3 * plan.tol_position,
                                       r.plan.error.angle, plan.tol_angle));
  row("execution", fmt::format("{:.1f} s", duration_s));
  row("plan", file.string());
}

}  // namespace

void write_trajectory(const fs::path& file, const std::vector<std::string>& joints, const planning::Trajectory& trajectory) {
  std::string text = "time_s";
  for (const auto& joint : joints) text += "," + joint;
  text += "\n";
  for (Eigen::Index k = 0; k < trajectory.times.size(); ++k) {
    text += fmt::format("{}", trajectory.times[k]);
    for (Eigen::Index j = 0; j < trajectory.u.rows(); ++j) text += fmt::format(",{}", trajectory.u(j, k));
    text += "\n";
  }
  tasks::write_text(text, file);
}

int run_refine(const RefineArguments& arguments) {
  const fs::path path = arguments.plan;
  const tasks::PlanFile file = tasks::read_plan(path);
  tasks::Task task = tasks::load_task_of_plan(file, path, data_dirs());
  if (file.status != Status::Solved)
    core::throw_invalid(path.string() + ": status", std::string(core::to_string(file.status)), "Solved: a plan that reaches its goal");
  const planning::PlannerOptions options = tasks::options_of_plan(*task.model, file, path);
  const fs::path dir =
      !arguments.out_dir.empty() ? fs::path(arguments.out_dir) : (fs::is_directory(path) ? path : path.parent_path()) / "refined";
  tasks::require_writable(dir);

  catch_signals();
  const core::RunControl control = make_run_control(arguments.timeout_s);
  RefineResult result;
  const Status status = planning::refine(task.model, tasks::to_plan(*task.model, file), options, {}, control, result);

  planning::PlanResult refined = tasks::to_result(*task.model, file);  // the statistics stay those of the search
  refined.plan = result.plan;
  refined.wall_s += result.wall_s;
  task.goal_from_command_line = file.goal_from_command_line;
  const fs::path target = dir / "plan.json";
  tasks::write_plan(tasks::make_plan_file(task, options, refined, target), target);
  const planning::Trajectory trajectory = planning::make_trajectory(*task.model, result.plan, speed_limits(arguments.speed));
  write_trajectory(dir / "trajectory.csv", file.joints, trajectory);
  print_summary(file, result, trajectory.duration(), target);

  std::string page;
  bool page_failed = false;
  if (arguments.html && status != Status::Cancelled) {
    page = (dir / "plan.html").string();
    page_failed = run_page_maker(target, page) != 0;
    fmt::print(stderr, "  {:22} {}\n", "page", page_failed ? "the page maker failed" : page);
  }
  if (arguments.json) {
    nlohmann::ordered_json out;
    out["status"] = core::to_string(result.status);
    out["task"] = file.task_name;
    out["seed"] = file.seed;
    out["wall_s"] = result.wall_s;
    out["iterations"] = result.steps;
    out["failed_steps"] = result.failed_steps;
    out["variant"] = result.variant;
    out["rests"] = result.rests;
    out["h"] = result.plan.step.h;
    out["led"] = result.led;
    out["corrected"] = result.corrected;
    out["pushes"] = {{"before", result.pushes_before}, {"after", result.pushes}};
    out["regrasps"] = {{"before", result.regrasps_before}, {"after", result.regrasps}, {"planned_anew", result.reconnected}};
    out["knots"] = {{"before", result.knots_before}, {"after", result.knots}};
    out["least_clearance"] = result.least_clearance;
    out["error"] = {{"position", result.plan.error.position}, {"angle", result.plan.error.angle}};
    out["duration_s"] = trajectory.duration();
    out["plan"] = target.string();
    out["trajectory"] = (dir / "trajectory.csv").string();
    fmt::print("{}\n", out.dump());
  }
  if (status == Status::Cancelled) return kInterrupted;
  if (status == Status::MaxIterations || status == Status::NumericalFailure) return kNotSolved;
  return page_failed ? kBadInput : kDone;
}

}  // namespace stiction::app
