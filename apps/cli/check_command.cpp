#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/open_loop/tube.hpp"
#include "stiction/tasks/check.hpp"

namespace stiction::app {

namespace {

struct CheckArguments {
  std::string plan;
  double timeout_s = 600;
  bool tube = false;
  execution::TubeOptions tubes;
  bool json = false;
};

constexpr double kDegree = std::numbers::pi / 180;

/// Infinity is no number of JSON.
nlohmann::ordered_json bound_json(double x) { return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json(); }

nlohmann::ordered_json tube_json(const tasks::PlanFile& plan, const execution::TubeOptions& options, const execution::TubeResult& tube) {
  const execution::ErrorSets& errors = options.errors;
  nlohmann::ordered_json out;
  out["status"] = core::to_string(tube.status);
  out["inside"] = tube.inside;
  out["calibrated"] = tube.calibrated;
  out["goal"] = {{"position", bound_json(tube.goal.position)}, {"angle", bound_json(tube.goal.angle)}};
  out["tolerance"] = {{"position", plan.tol_position}, {"angle", plan.tol_angle}};
  out["errors"] = {{"position", errors.position},
                   {"angle", errors.angle},
                   {"friction", errors.friction},
                   {"mass", errors.mass},
                   {"contact", errors.contact}};
  out["factors"] = {{"position", options.factors.position}, {"angle", options.factors.angle}, {"made_by", execution::kTubeFactorsMadeBy}};
  out["scenarios"] = options.scenarios;
  out["lost"] = tube.lost;
  out["steps"] = tube.steps;
  out["wall_s"] = tube.wall_s;
  out["rests"] = nlohmann::ordered_json::array();
  for (const auto& rest : tube.rests) {
    out["rests"].push_back({{"kind", rest.kind == planning::SegmentKind::Contact ? "push" : "regrasp"},
                            {"last_segment", rest.last_segment},
                            {"offset_position", rest.offset.position},
                            {"offset_angle", rest.offset.angle},
                            {"position", bound_json(rest.position)},
                            {"angle", bound_json(rest.angle)}});
  }
  return out;
}

std::string_view verdict_of(const execution::TubeResult& tube) {
  if (tube.status != core::Status::Solved) return core::to_string(tube.status);
  if (tube.inside) return "yes";
  return tube.calibrated ? "no" : "no (in scenes that are not planar, runs often leave this bound)";
}

void print_tube(std::FILE* to, const tasks::PlanFile& plan, const execution::TubeOptions& options, const execution::TubeResult& tube) {
  const execution::ErrorSets& errors = options.errors;
  say(to, "pose of the object at the end of each push and regrasp, from {} random worlds in {:.3f} s:\n", options.scenarios, tube.wall_s);
  say(to, "  largest errors: start {:g} mm and {:g}°, friction {:g} %, masses {:g} %, gaps of contacts {:g} % of the object's size\n",
      1e3 * errors.position, errors.angle / kDegree, 1e2 * errors.friction, 1e2 * errors.mass, 1e2 * errors.contact);
  say(to, "  {:4} {:8} {:>8}   {:>21}   {:>21}\n", "", "end of", "segment", "mean off plan mm, °", "radius mm, °");
  for (std::size_t i = 0; i < tube.rests.size(); ++i) {
    const auto& rest = tube.rests[i];
    say(to, "  {:4} {:8} {:8}   {:12.2f} {:8.2f}   {:12.2f} {:8.2f}\n", i, rest.kind == planning::SegmentKind::Contact ? "push" : "regrasp",
        rest.last_segment, 1e3 * rest.offset.position, rest.offset.angle / kDegree, 1e3 * rest.position, rest.angle / kDegree);
  }
  if (tube.lost > 0) say(to, "  there is no bound: in {} worlds a step has no solution\n", tube.lost);
  if (tube.status == core::Status::Solved) {
    say(to, "  distance from the goal: at most {:.2f} mm (tolerance {:g}), {:.2f}° (tolerance {:.2f})\n", 1e3 * tube.goal.position,
        1e3 * plan.tol_position, tube.goal.angle / kDegree, plan.tol_angle / kDegree);
  }
  say(to, "  inside the goal's tolerance: {}\n", verdict_of(tube));
  say(to, "  each radius is the spread of the worlds times {:g} (position) or {:g} (angle); these factors are from {}\n",
      options.factors.position, options.factors.angle, execution::kTubeFactorsMadeBy);
}

void print_report(std::FILE* to, const tasks::PlanFile& plan, const tasks::CheckReport& report, std::string_view verdict) {
  say(to, "{}, seed {}: {} knots re-simulated at half the sub-step in {:.3f} s: {}\n", plan.task_name, plan.seed, report.knots,
      report.wall_s, verdict);
  for (const auto& item : report.items) {
    const std::string limit = item.limit ? fmt::format("≤ {:<9.3g}", *item.limit) : fmt::format("{:11}", "");
    say(to, "  {} {:16} {:>10.3g} {} {}{}\n",
        !item.limit ? "    "
        : item.pass ? "ok  "
                    : "FAIL",
        item.name, item.value, limit, item.unit, item.where.empty() || item.value == 0 ? "" : "  (" + item.where + ")");
  }
  if (plan.start_from_command_line) say(to, "  the start was given by the caller, not by the task\n");
  if (plan.goal_from_command_line) say(to, "  the goal was given by the caller, not by the task\n");
  if (plan.options_from_command_line) say(to, "  the options were given by the caller, not by the task\n");
  say(to, "  forces below {:.3g} N are not checked\n", report.threshold_N);
}

nlohmann::ordered_json report_json(const tasks::PlanFile& plan, const tasks::CheckReport& report, std::string_view verdict) {
  nlohmann::ordered_json out;
  out["status"] = verdict;
  out["task"] = plan.task_name;
  out["plan_status"] = core::to_string(plan.status);
  out["seed"] = plan.seed;
  out["wall_s"] = report.wall_s;
  out["steps"] = report.steps;
  out["knots"] = report.knots;
  out["start_from"] = plan.start_from_command_line ? "command_line" : "task";
  out["goal_from"] = plan.goal_from_command_line ? "command_line" : "task";
  out["options_from"] = plan.options_from_command_line ? "command_line" : "task";
  out["force_threshold"] = report.threshold_N;
  out["checks"] = nlohmann::ordered_json::array();
  for (const auto& item : report.items) {
    nlohmann::ordered_json entry;
    entry["name"] = item.name;
    entry["value"] = item.value;
    entry["limit"] = item.limit ? nlohmann::ordered_json(*item.limit) : nlohmann::ordered_json();
    entry["unit"] = item.unit;
    entry["pass"] = item.pass;
    entry["where"] = item.where;
    out["checks"].push_back(std::move(entry));
  }
  return out;
}

int run_check(const CheckArguments& arguments) {
  const core::RunControl control = make_run_control(arguments.timeout_s);  // what is read counts too
  arguments.tubes.validate();
  const std::filesystem::path path = arguments.plan;
  const tasks::PlanFile plan = tasks::read_plan(path);
  const tasks::Task task = tasks::load_task_of_plan(plan, path, data_dirs());

  catch_signals();
  tasks::CheckReport report;
  const core::Status status = tasks::check_plan(task, plan, {}, control, report);
  const std::string_view verdict = status != core::Status::Solved ? core::to_string(status) : report.pass ? "Passed" : "Failed";

  std::FILE* const to = people(arguments.json);
  print_report(to, plan, report, verdict);
  execution::TubeResult tube;
  if (arguments.tube && status == core::Status::Solved) {
    (void)execution::calc_tube(task.model, tasks::to_plan(*task.model, plan), arguments.tubes, control, tube);
    print_tube(to, plan, arguments.tubes, tube);
  }

  if (arguments.json) {
    nlohmann::ordered_json out = report_json(plan, report, verdict);
    if (arguments.tube) out["tube"] = tube_json(plan, arguments.tubes, tube);
    say(stdout, "{}\n", out.dump());
  }
  for (const core::Status ended : {status, arguments.tube ? tube.status : status}) {
    if (ended == core::Status::Cancelled) return kInterrupted;
    if (ended != core::Status::Solved) return kNotSolved;
  }
  return report.pass && (tube.inside || !arguments.tube) ? kDone : kCheckFailed;
}

void add_tube(CLI::App& command, CheckArguments& a) {
  CLI::Option* const tube = command.add_flag(
      "--tube", a.tube,
      "Also bound the object's pose at the end of each push and regrasp of a run without feedback, and say whether the object ends within "
      "the tolerance of its goal");
  execution::ErrorSets& errors = a.tubes.errors;
  for (CLI::Option* option : {
           add_number(command, "--start-error", errors.position, "Largest position error of an object at the start [m]",
                      Bound::NonNegative),
           add_number(command, "--start-turn", errors.angle, "Largest angle error of an object at the start [rad]", Bound::NonNegative),
           add_number(command, "--friction-error", errors.friction,
                      "Largest relative error of the coefficients of friction, the same for all of them", Bound::NonNegative),
           add_number(command, "--mass-error", errors.mass, "Largest relative error of the masses of objects, the same for all of them",
                      Bound::NonNegative),
           add_integer(command, "--worlds", a.tubes.scenarios, "Number of random worlds that are drawn within these errors", {1, 10000}),
       })
    option->needs(tube);
}

}  // namespace

Run declare_check(CLI::App& command) {
  const auto arguments = std::make_shared<CheckArguments>();
  CheckArguments& a = *arguments;
  add_plan(command, a.plan);
  add_timeout(command, a.timeout_s);
  add_tube(command, a);
  add_json(command, a.json);
  return [arguments] { return run_check(*arguments); };
}

}  // namespace stiction::app
