#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "control_page.hpp"
#include "stiction/execution/contact_control/control_run.hpp"
#include "stiction/tasks/control_scenario_file.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/scenarios.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::app {
namespace {

using core::Status;
using json = nlohmann::ordered_json;

constexpr std::pair<const char*, control::Law> kLaws[] = {{"contact_aware", control::Law::ContactAware},
                                                          {"unconstrained", control::Law::Unconstrained},
                                                          {"null_space", control::Law::NullSpace},
                                                          {"force_equality", control::Law::ForceEquality}};

struct ControlArguments {
  std::string scenario;
  std::string law;                   ///< empty: as the scenario says
  std::optional<double> lambda_max;  ///< [N]
  std::optional<double> friction_scale;
  std::string contacts;  ///< empty: as the scenario says
  std::optional<double> delay_s, period_s;
  std::optional<std::uint64_t> seed;
  double tolerance = 0.2;
  double settle_s = execution::ControlRunOptions{}.settle;
  double timeout_s = 600;
  std::string out_dir;
  std::string html;
  bool json = false;
};

std::string_view law_name(control::Law law) {
  for (const auto& [name, value] : kLaws)
    if (value == law) return name;
  return "";
}

execution::ControlScenario load(const ControlArguments& arguments) {
  const auto package_dirs = tasks::default_package_dirs();
  execution::ControlScenario scenario = tasks::load_control_scenario(tasks::find_scenario(arguments.scenario, data_dirs()), package_dirs);
  for (const auto& [name, value] : kLaws)
    if (arguments.law == name) scenario.controller.law = value;
  if (arguments.lambda_max) execution::set_lambda_max(scenario, *arguments.lambda_max);
  if (arguments.friction_scale) scenario.plant.contact.friction_scale = *arguments.friction_scale;
  if (!arguments.contacts.empty())
    scenario.contacts = arguments.contacts == "true" ? execution::ContactSource::True : execution::ContactSource::Estimated;
  if (arguments.delay_s) scenario.delay = *arguments.delay_s;
  if (arguments.period_s) scenario.period = *arguments.period_s;
  if (arguments.seed) scenario.observer.seed = *arguments.seed;
  return scenario;
}

/// A line a tick: time, largest force, its bound, joint speed, tracking error, then joints and commands.
std::string write_samples(const execution::ControlScenario& scenario, const execution::ControlRunResult& r) {
  std::string text = "time,force,bounded,slack,speed,error,angle_error";
  const world::Model& model = *scenario.model;
  for (const char* kind : {"q", "q_cmd"})
    for (int j = 0; j < model.n_a(); ++j)
      text += fmt::format(",{}:{}", kind, model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name);
  text += '\n';
  for (const execution::ControlSample& s : r.samples) {
    text += fmt::format("{:.6g},{:.6g},{},{:.6g},{:.6g},{:.6g},{:.6g}", s.time, s.largest_force, s.bounded ? 1 : 0, s.slack, s.speed,
                        s.error, s.angle_error);
    for (const Eigen::VectorXd* v : {&s.q, &s.q_cmd})
      for (const double x : *v) text += fmt::format(",{:.9g}", x);
    text += '\n';
  }
  return text;
}

/// False if the robot made contacts, but none was old enough to count as settled.
bool is_judged(const execution::ControlRunResult& r) { return r.settled_ticks > 0 || r.makes == 0; }

void print_summary(std::FILE* to, const execution::ControlScenario& scenario, const execution::ControlRunResult& r, bool passes) {
  const auto row = [to](std::string_view name, const std::string& value) { print_row(to, name, value); };
  say(to, "{}, {}: {}\n", scenario.name, law_name(scenario.controller.law),
      r.status != Status::Solved ? std::string(core::to_string(r.status))
      : !is_judged(r)            ? "no contact lasted as long as --settle, so no force was judged"
      : passes                   ? "forces bounded"
                                 : "forces above their bound");
  if (!r.message.empty()) row("simulation", r.message);
  row("force bound", fmt::format("{:.1f} N", scenario.controller.lambda_max));
  row("largest force", fmt::format("{:.1f} N, impacts included", r.peak_force));
  row("settled force", fmt::format("at most {:.1f} N, mean {:.1f} N", r.settled_peak, r.mean_force));
  if (r.bounded_ticks > 0)
    row("at the bound", fmt::format("for {:.2f} s, mean error {:.2f} N, 95th percentile of the force {:.1f} N",
                                    r.bounded_ticks * scenario.period, r.bound_error, r.bound_p95));
  if (r.above_ticks > 0)
    row("above 1.2 × bound", fmt::format("in {} of {} control periods with a settled contact", r.above_ticks, r.settled_ticks));
  row("fastest rise", fmt::format("{:.1f} N in one control period, of which the command causes {:.1f} N", r.peak_rise, r.commanded_rise));
  row("fastest fall", fmt::format("{:.0f} N/s", r.peak_force_rate));
  row("contacts made", fmt::format("{}", r.makes));
  const std::string unit = error_unit(scenario);
  row("tracking error", fmt::format("{:.1f} {} rms in contact, {:.1f} {} rms without contact", 1e3 * r.rms_error_contact, unit,
                                    1e3 * r.rms_error_free, unit));
  row("bound relaxed",
      fmt::format("in {} of {} control periods; {} without a solution", r.slack_ticks, r.samples.size(), r.unsolved_ticks));
  if (scenario.contacts == execution::ContactSource::Estimated)
    row("time per estimate", fmt::format("median {:.2f} ms, 99th percentile {:.2f} ms", 1e3 * r.sense_median_s, 1e3 * r.sense_p99_s));
  row("time per command", fmt::format("median {:.1f} us, 99th percentile {:.1f} us", 1e6 * r.tick_median_s, 1e6 * r.tick_p99_s));
}

json report(const execution::ControlScenario& scenario, const execution::ControlRunResult& r, bool passes) {
  return {{"status", r.status == Status::Solved ? (passes ? "Passed" : "Failed") : std::string(core::to_string(r.status))},
          {"scenario", scenario.name},
          {"law", law_name(scenario.controller.law)},
          {"message", r.message},
          {"lambda_max", scenario.controller.lambda_max},
          {"duration_s", static_cast<double>(r.samples.size()) * scenario.period},
          {"peak_force", r.peak_force},
          {"settled_peak", r.settled_peak},
          {"mean_force", r.mean_force},
          {"bounded_s", r.bounded_ticks * scenario.period},
          {"bound_error", r.bound_error},
          {"bound_p95", r.bound_p95},
          {"settled_ticks", r.settled_ticks},
          {"above_ticks", r.above_ticks},
          {"peak_rise", r.peak_rise},
          {"commanded_rise", r.commanded_rise},
          {"peak_force_rate", r.peak_force_rate},
          {"contacts_made", r.makes},
          {"rms_error_contact", r.rms_error_contact},
          {"rms_error_free", r.rms_error_free},
          {"peak_speed", r.peak_speed},
          {"slack_ticks", r.slack_ticks},
          {"unsolved_ticks", r.unsolved_ticks},
          {"contacts", scenario.contacts == execution::ContactSource::Estimated ? "estimated" : "true"},
          {"delay_s", scenario.delay},
          {"sense_median_s", r.sense_median_s},
          {"sense_p99_s", r.sense_p99_s},
          {"tick_median_s", r.tick_median_s},
          {"tick_p99_s", r.tick_p99_s}};
}

/// What of a run is held against the bound: the 95th percentile where the reference asks for more, as the acceptance list has it. Single ticks are reported: friction
/// that turns round in one contact loads another one in a tick, whatever the command does.
double judged_force(const execution::ControlRunResult& r) { return r.bounded_ticks > 0 ? r.bound_p95 : r.settled_peak; }

int run_control_command(const ControlArguments& arguments) {
  const execution::ControlScenario scenario = load(arguments);
  if (!arguments.out_dir.empty()) tasks::require_writable(arguments.out_dir);
  require_page(arguments.html);
  catch_signals();
  execution::ControlRunOptions options;
  options.settle = arguments.settle_s;
  options.control = make_run_control(arguments.timeout_s);
  execution::ControlRunResult result;
  const Status status = execution::run_control(scenario, options, result);
  const bool passes = status == Status::Solved && result.unsolved_ticks == 0 && is_judged(result) &&
                      judged_force(result) <= (1 + arguments.tolerance) * scenario.controller.lambda_max;
  std::FILE* const to = people(arguments.json);
  print_summary(to, scenario, result, passes);
  json out = report(scenario, result, passes);
  if (!arguments.out_dir.empty()) {
    const auto file = std::filesystem::path(arguments.out_dir) / "control.csv";
    tasks::write_text(write_samples(scenario, result), file);
    print_row(to, "samples", file.string());
    out["samples"] = file.string();
  }
  bool page_failed = false;
  if (!arguments.html.empty() && !result.samples.empty()) {
    page_failed = !write_page(control_document(scenario, result, law_name(scenario.controller.law)), arguments.html, to);
    if (!page_failed) out["page"] = arguments.html;
  }
  if (arguments.json) say(stdout, "{}\n", out.dump());
  return exit_code(status, page_failed, passes);
}

}  // namespace

Run declare_control(CLI::App& command) {
  const auto arguments = std::make_shared<ControlArguments>();
  ControlArguments& a = *arguments;
  command.add_option("scenario", a.scenario, "Name of a built-in scenario, or a scenario file (.yaml)")->required();
  std::vector<std::string> laws;
  for (const auto& [name, value] : kLaws) laws.emplace_back(name);
  command.add_option("--law", a.law, "Control law that computes the command (default: as in the scenario)")->check(CLI::IsMember(laws));
  add_number(command, "--lambda-max", a.lambda_max, "Bound on the force of each contact [N] (default: as in the scenario)",
             Bound::Positive);
  add_number(command, "--friction", a.friction_scale, "Factor on every coefficient of friction in the simulation", Bound::NonNegative);
  command
      .add_option("--contacts", a.contacts,
                  "Source of the contacts for the controller: true from the simulation, or estimated from joint torques (default: as in "
                  "the scenario)")
      ->check(CLI::IsMember({"true", "estimated"}));
  add_number(command, "--delay", a.delay_s, "Age of the contact data when the controller receives them [s] (default: as in the scenario)",
             Bound::NonNegative);
  add_number(command, "--period", a.period_s, "Time between two commands [s] (default: as in the scenario)", Bound::Positive);
  add_seed(command, a.seed, "Seed of the noise of joint torques (default: as in the scenario)");
  add_number(
      command, "--tolerance", a.tolerance,
      "Share of the bound by which settled contact forces may exceed the bound. The 95th percentile of forces at the bound is judged, or "
      "the largest settled force if no force reaches its bound",
      Bound::NonNegative);
  add_number(command, "--settle", a.settle_s, "Time from the start of a contact until its force counts as settled and is judged [s]",
             Bound::NonNegative);
  add_timeout(command, a.timeout_s);
  add_out(command, a.out_dir, "Folder for control.csv, with one line per control period (default: no file)");
  command.add_option("--html", a.html, "HTML page to write, with the motion of the arm, contact forces, errors and torques over time");
  add_json(command, a.json);
  return [arguments] { return run_control_command(*arguments); };
}

}  // namespace stiction::app
