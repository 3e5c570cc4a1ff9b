#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "stiction/tasks/check.hpp"

namespace stiction::app {

namespace {

struct CheckArguments {
  std::string plan;
  double timeout_s = 600;
  bool json = false;
};

int run_check(const CheckArguments& arguments) {
  const core::RunControl control = make_run_control(arguments.timeout_s);  // what is read counts too
  const std::filesystem::path path = arguments.plan;
  const tasks::PlanFile plan = tasks::read_plan(path);
  const tasks::Task task = tasks::load_task_of_plan(plan, path, data_dirs());

  catch_signals();
  tasks::CheckReport report;
  const core::Status status = tasks::check_plan(task, plan, {}, control, report);
  const std::string_view verdict = status != core::Status::Solved ? core::to_string(status) : report.pass ? "Passed" : "Failed";

  std::FILE* const to = people(arguments.json);
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
  if (plan.start_from_command_line) say(to, "  the start is a given one, not that of the task\n");
  if (plan.goal_from_command_line) say(to, "  the goal is one of the command line, not that of the task\n");
  if (plan.options_from_command_line) say(to, "  the options are given ones, not those of the task\n");
  say(to, "  forces below {:.3g} N are not looked at\n", report.threshold_N);

  if (arguments.json) {
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
    say(stdout, "{}\n", out.dump());
  }
  if (status == core::Status::Cancelled) return kInterrupted;
  if (status != core::Status::Solved) return kNotSolved;
  return report.pass ? kDone : kCheckFailed;
}

}  // namespace

Run declare_check(CLI::App& command) {
  const auto arguments = std::make_shared<CheckArguments>();
  CheckArguments& a = *arguments;
  add_plan(command, a.plan);
  add_timeout(command, a.timeout_s);
  add_json(command, a.json);
  return [arguments] { return run_check(*arguments); };
}

}  // namespace stiction::app
