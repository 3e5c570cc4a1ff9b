#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "control_page.hpp"
#include "guarded_report.hpp"
#include "page_scene.hpp"
#include "stiction/execution/touch/guarded_run.hpp"
#include "stiction/execution/touch/touch_run.hpp"
#include "stiction/tasks/scenarios.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/tasks/touch_scenario_file.hpp"
#include "stiction/world/scales.hpp"
#include "touch_command.hpp"
#include "touch_page.hpp"

namespace stiction::app {
namespace {

using core::Status;
using execution::GuardedRunResult;
using execution::TouchOutcome;
using execution::TouchRunResult;
using execution::TouchScenario;
using json = nlohmann::ordered_json;

struct TouchArguments {
  std::string scenario;
  std::optional<std::uint64_t> seed;
  double tolerance = 0.2;
  double timeout_s = 600;
  std::string html;
  bool json = false;
};

std::string link_of(const TouchScenario& scenario, const execution::Touch& touch) {
  return scenario.arm.model->bodies()[static_cast<std::size_t>(touch.body)].name;
}

void print_touch(std::FILE* to, const TouchScenario& scenario, const execution::Touch& touch) {
  const Eigen::Vector3d& p = touch.place.p_W;
  const std::string off = std::isfinite(touch.error) ? fmt::format(", error {:.1f} cm", 100 * touch.error) : "";
  say(to, "  {:6.2f} s  {:14} ({:6.3f} {:6.3f} {:6.3f}) m{}  {:4.1f} N  mapped as a ball of radius {:.1f} cm\n", touch.time,
      link_of(scenario, touch), p.x(), p.y(), p.z(), off, touch.force, 100 * touch.radius);
}

TouchVerdict judge(const TouchRunResult& r, bool bounded) {
  return {r.status, r.outcome == TouchOutcome::Reached, std::string(execution::to_string(r.outcome)), r.reason, bounded};
}

void print_summary(std::FILE* to, const TouchScenario& scenario, const TouchRunResult& r, bool bounded) {
  const auto row = [to](std::string_view name, const std::string& value) { print_row(to, name, value); };
  print_head(to, scenario, judge(r, bounded), "reached its goal");
  if (r.status == Status::NumericalFailure) row("simulation", r.reason);
  row("contacts felt", fmt::format("{}", r.touches.size()));
  for (const auto& touch : r.touches) print_touch(to, scenario, touch);
  double planning = 0;
  for (const auto& planned : r.routes) planning = std::max(planning, planned.wall_s);
  row("paths planned", fmt::format("{}, in at most {:.2f} s each", r.routes.size(), planning));
  row("force bound", fmt::format("{:.1f} N", scenario.arm.controller.lambda_max));
  row("largest force", fmt::format("{:.1f} N, impacts included", r.run.peak_force));
  row("settled force", fmt::format("at most {:.1f} N, mean {:.1f} N", r.run.settled_peak, r.run.mean_force));
  const world::Model& model = *scenario.arm.model;
  const bool slides = std::ranges::any_of(model.dofs().last(static_cast<std::size_t>(model.n_a())),
                                          [](const auto& dof) { return dof.kind == world::DofKind::Prismatic; });
  const std::string unit = slides ? fmt::format("; 1 rad stands for {:.3g} m of a sliding joint", model.scales().robots().length) : "";
  row("error at the goal", fmt::format("{:.2g} rad (tolerance {:.2g}{})", r.goal_error, scenario.tolerance, unit));
  row("duration", fmt::format("{:.1f} s simulated", static_cast<double>(r.run.samples.size()) * scenario.arm.period));
}

json to_json(const TouchScenario& scenario, const execution::Touch& touch) {
  return {{"time_s", touch.time},
          {"link", link_of(scenario, touch)},
          {"p_W", page_numbers(touch.place.p_W)},
          {"n_W", page_numbers(touch.place.n_W)},
          {"spread", touch.place.spread},
          {"force", touch.force},
          {"radius", touch.radius},
          {"doubted", touch.doubted},
          {"error", std::isfinite(touch.error) ? json(touch.error) : json()}};
}

json report(const TouchScenario& scenario, const TouchRunResult& r, std::uint64_t seed, bool bounded, double wall_s) {
  json out = report_head(scenario, judge(r, bounded), r.run, seed, wall_s);
  out.update({{"goal_error", r.goal_error},
              {"peak_force", r.run.peak_force},
              {"settled_peak", r.run.settled_peak},
              {"mean_force", r.run.mean_force},
              {"contacts_made", r.run.makes},
              {"unsolved_ticks", r.run.unsolved_ticks},
              {"sense_median_s", r.run.sense_median_s}});
  out["touches"] = out["routes"] = json::array();
  for (const auto& touch : r.touches) out["touches"].push_back(to_json(scenario, touch));
  for (const auto& planned : r.routes)
    out["routes"].push_back({{"time_s", planned.time},
                             {"found", planned.route.outcome == contact::PathOutcome::Found},
                             {"share", planned.route.share},
                             {"postures", planned.route.postures.size()},
                             {"travel", planned.route.travel},
                             {"wall_s", planned.wall_s}});
  return out;
}

/// Page, object and exit code of a run that has printed its summary.
int finish(const TouchArguments& arguments, const TouchVerdict& verdict, const execution::ControlRunResult& run,
           const std::function<std::string()>& document, std::FILE* to, json out) {
  const bool shown = !arguments.html.empty() && !run.samples.empty();
  const bool page_failed = shown && !write_page(document(), arguments.html, to);
  if (shown && !page_failed) out["page"] = arguments.html;
  if (arguments.json) say(stdout, "{}\n", out.dump());
  const ExitCode code = exit_code(verdict.status, page_failed, verdict.passes());
  return code == kDone && !verdict.reached ? kNotSolved : code;
}

int run_moves(const TouchScenario& scenario, const TouchArguments& arguments, const execution::TouchRunOptions& options) {
  const auto started = core::RunControl::Clock::now();
  GuardedRunResult result;
  (void)execution::run_guarded(scenario, options, result);
  const double wall_s = core::seconds_since(started);
  const bool gentle = is_gentle(scenario, result, arguments.tolerance);
  std::FILE* const to = people(arguments.json);
  print_moves(to, scenario, result, gentle);
  const auto document = [&] {
    execution::ControlScenario arm = scenario.arm;
    arm.model = result.world;
    return control_document(arm, result.run, "contact_aware");
  };
  return finish(arguments, judge_moves(result, gentle), result.run, document, to,
                report_moves(scenario, result, options.seed, gentle, wall_s));
}

int run_touch_command(const TouchArguments& arguments) {
  const TouchScenario scenario =
      tasks::load_touch_scenario(tasks::find_scenario(arguments.scenario, data_dirs()), tasks::default_package_dirs());
  require_page(arguments.html);
  catch_signals();
  execution::TouchRunOptions options;
  options.seed = arguments.seed.value_or(scenario.arm.observer.seed);
  options.control = make_run_control(arguments.timeout_s);
  if (!scenario.moves.empty()) return run_moves(scenario, arguments, options);
  const auto started = core::RunControl::Clock::now();
  TouchRunResult result;
  (void)execution::run_touch(scenario, options, result);
  const double wall_s = core::seconds_since(started);
  const bool bounded =
      result.run.unsolved_ticks == 0 && result.run.settled_peak <= (1 + arguments.tolerance) * scenario.arm.controller.lambda_max;
  std::FILE* const to = people(arguments.json);
  print_summary(to, scenario, result, bounded);
  const auto document = [&] { return touch_document(scenario, result); };
  return finish(arguments, judge(result, bounded), result.run, document, to, report(scenario, result, options.seed, bounded, wall_s));
}

}  // namespace

Run declare_touch(CLI::App& command) {
  const auto arguments = std::make_shared<TouchArguments>();
  TouchArguments& a = *arguments;
  command.add_option("scenario", a.scenario, "Name of a built-in scenario, or a scenario file (.yaml)")->required();
  add_seed(command, a.seed,
           "Seed of the noise of joint torques, of the places of unknown bodies, and of the paths (default: as in the scenario)");
  add_number(command, "--tolerance", a.tolerance, "Share of the bound by which settled contact forces may exceed the bound",
             Bound::NonNegative);
  add_timeout(command, a.timeout_s);
  command.add_option("--html", a.html,
                     "HTML page to write, with the motion of the arm, the contacts that it felt, its planned paths and the forces");
  add_json(command, a.json);
  return [arguments] { return run_touch_command(*arguments); };
}

}  // namespace stiction::app
