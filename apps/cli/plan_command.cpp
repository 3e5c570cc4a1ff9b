#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/planning/press_limits.hpp"
#include "stiction/planning/thresholds.hpp"
#include "stiction/tasks/lint.hpp"
#include "stiction/tasks/optimize_options.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;
using core::Status;

struct PlanArguments {
  std::string task;
  std::optional<std::uint64_t> seed;
  std::string goal;
  double timeout_s = 20;
  std::optional<int> threads;
  std::string out_dir;
  std::string scheme;   ///< empty: that of the task
  std::string without;  ///< mechanisms of the search that are left out, for ablations
  bool anytime = false;
  bool html = false;
  bool profile = false;
  bool json = false;
};

/// Names with commas between as bits of PlannerOptions::without.
unsigned parse_mechanisms(const std::string& names) {
  const auto& known = planning::kMechanismNames;
  unsigned out = 0;
  for (std::size_t begin = 0; begin < names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    const auto found = std::ranges::find(known, std::string_view(names).substr(begin, end - begin));
    if (found == known.end()) core::throw_invalid("--without", names, fmt::format("names among {}", fmt::join(known, ", ")));
    out |= 1U << static_cast<unsigned>(found - known.begin());
    begin = end + 1;
  }
  return out;
}

struct Counts {
  long knots = 0, regrasps = 0, unstable = 0, contact_segments = 0;
  explicit Counts(const planning::Plan& plan) {
    for (const auto& segment : plan.segments) {
      knots += static_cast<long>(segment.knots.size());
      regrasps += segment.kind == planning::SegmentKind::Regrasp;
      unstable += segment.unstable;
      contact_segments += segment.kind == planning::SegmentKind::Contact;
    }
  }
};

void print_summary(std::FILE* to, const tasks::Task& task, const planning::PlannerOptions& o, const planning::PlanResult& r,
                   const fs::path& file) {
  const Counts counts(r.plan);
  const auto row = [to](std::string_view name, const std::string& value) { print_row(to, name, value); };
  const std::string_view outcome = r.status == Status::Solved          ? "solved"
                                   : r.status == Status::MaxIterations ? "no plan within the budget; this is the best path"
                                                                       : core::to_string(r.status);
  say(to, "{}, seed {}: {}\n", task.name, r.seed, outcome);
  row("time", fmt::format("{:.3f} s", r.wall_s));
  row("error at the goal", fmt::format("{:.2f} mm (tolerance {:.0f}), {:.4f} rad (tolerance {:.2f})", 1e3 * r.plan.error.position,
                                       1e3 * r.plan.goal.tol_position, r.plan.error.angle, r.plan.goal.tol_angle));
  row("path", fmt::format("{} pushes, {} regrasps, {} sub-steps", counts.contact_segments, counts.regrasps, counts.knots));
  if (counts.unstable > 0)
    row("unstable", fmt::format("{} of the regrasps: an object would move during them if gravity were tilted by {:g} rad", counts.unstable,
                                planning::threshold::kReleaseTilt));
  row("cost", fmt::format("{:.1f} s at nominal joint speeds, including {:.0f} s per regrasp{}", r.cost, planning::PathCost{}.regrasp,
                          r.improvements.size() > 1 ? fmt::format("; cost of the first plan {:.1f} s", r.improvements.front().cost) : ""));
  if (r.plan.step.friction_scale < o.friction)
    row("friction", fmt::format("every coefficient is {:g} times that of the scene", r.plan.step.friction_scale));
  if (const auto press = planning::largest_press(*task.model, r.plan))
    row("largest force", fmt::format("{:.0f} % of the force that the weaker body of the pair bears (max_force)", 100 * *press));
  row("tree", fmt::format("{} extensions, {} nodes", r.iterations, r.nodes));
  row("work", fmt::format("{} simulation steps, {} of them failed; {} local models", r.steps, r.failed_steps, r.linearisations));
  row("given up", fmt::format("{} edges that gave another motion in half steps", r.distrusted));
  const auto& g = r.regrasps;
  row("regrasps tried", fmt::format("{} ({} accepted; no posture {}, no path {}, object moved {}, failed step {})", g.tried, g.accepted,
                                    g.no_sample, g.no_path, g.object_moved, g.failed_step));
  if (task.options.thesis)
    row("edges", "as published, not simulated in sub-steps; `stiction check` simulates them in sub-steps, and may reject them");
  if (!r.reason.empty()) row("reason", r.reason);
  if (r.start_moved > 1e-3) row("start", fmt::format("an object was not at rest, and first moved by {:.3g} (m or rad)", r.start_moved));
  if (r.start_projected)
    row("start", fmt::format("bodies penetrated each other by {:.2f} mm; the planner first moved them apart", 1e3 * r.start_penetration));
  row("plan", file.string());
}

nlohmann::ordered_json to_json(const tasks::Task& task, const planning::PlanResult& r, const fs::path& file, const std::string& page,
                               const std::vector<tasks::Finding>& findings) {
  const Counts counts(r.plan);
  nlohmann::ordered_json out;
  out["status"] = core::to_string(r.status);
  out["task"] = task.name;
  out["seed"] = r.seed;
  out["wall_s"] = r.wall_s;
  out["iterations"] = r.iterations;
  out["nodes"] = r.nodes;
  out["steps"] = r.steps;
  out["linearisations"] = r.linearisations;
  out["failed_steps"] = r.failed_steps;
  out["distrusted"] = r.distrusted;
  out["regrasps"] = {{"in_plan", counts.regrasps},
                     {"unstable", counts.unstable},
                     {"tried", r.regrasps.tried},
                     {"accepted", r.regrasps.accepted},
                     {"no_sample", r.regrasps.no_sample},
                     {"no_path", r.regrasps.no_path},
                     {"object_moved", r.regrasps.object_moved},
                     {"failed_step", r.regrasps.failed_step}};
  out["thesis_edges"] = task.options.thesis.has_value();
  out["error"] = {{"position", r.plan.error.position}, {"angle", r.plan.error.angle}};
  out["tolerance"] = {{"position", r.plan.goal.tol_position}, {"angle", r.plan.goal.tol_angle}};
  out["cost"] = r.cost;
  out["friction"] = r.plan.step.friction_scale;
  out["improvements"] = nlohmann::ordered_json::array();
  for (const auto& i : r.improvements)
    out["improvements"].push_back({{"cost", i.cost}, {"iterations", i.iterations}, {"wall_s", i.wall_s}});
  const auto press = planning::largest_press(*task.model, r.plan);
  out["press"] = press ? nlohmann::ordered_json(*press) : nlohmann::ordered_json();
  out["segments"] = r.plan.segments.size();
  out["knots"] = counts.knots;
  out["warnings"] = nlohmann::ordered_json::array();
  for (const auto& finding : findings) out["warnings"].push_back(finding.message);
  out["reason"] = r.reason.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(r.reason);
  out["start_moved"] = r.start_moved;
  out["start_projected"] = r.start_projected;
  out["start_penetration"] = r.start_penetration;
  for (std::size_t i = 0; i < r.profile.entries.size(); ++i) {
    const auto& [seconds, calls] = r.profile.entries[i];
    out["profile"][std::string(planning::kActivityNames[i])] = {{"processor_s", seconds}, {"calls", calls}};
  }
  out["plan"] = file.string();
  out["page"] = page.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(page);
  return out;
}

/// Activities by processor time, the longest first.
std::vector<std::size_t> by_time(const planning::Profile& profile) {
  std::vector<std::size_t> order(profile.entries.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return profile.entries[i].processor_s; });
  return order;
}

void print_profile(std::FILE* to, const planning::Profile& profile) {
  double sum = 0;
  for (const auto& entry : profile.entries) sum += entry.processor_s;
  say(to, "  {:<16} {:>12} {:>7} {:>9} {:>12}\n", "activity", "processor s", "share", "calls", "µs per call");
  for (const std::size_t i : by_time(profile)) {
    const auto& [seconds, calls] = profile.entries[i];
    if (calls == 0) continue;
    say(to, "  {:<16} {:>12.3f} {:>5.0f} % {:>9} {:>12.1f}\n", planning::kActivityNames[i], seconds, 100 * seconds / sum, calls,
        1e6 * seconds / static_cast<double>(calls));
  }
}

int run_plan(const PlanArguments& arguments) {
  core::RunControl control = make_run_control(arguments.timeout_s);  // what is read counts too
  tasks::Task task = tasks::load_task(arguments.task, data_dirs());
  print_notes(task);
  if (!arguments.goal.empty()) tasks::set_goal(task, parse_numbers("--goal", arguments.goal));
  planning::PlannerOptions options = task.options;
  options.seed = arguments.seed.value_or(options.seed);
  options.threads = arguments.threads.value_or(options.threads);
  if (!arguments.scheme.empty()) {
    if (!options.thesis)
      core::throw_invalid("--scheme", arguments.scheme,
                          "a task with settings of the thesis, planner.thesis, such as planar_hand_table_3_2");
    options.thesis->scheme = tasks::parse_scheme("--scheme", arguments.scheme);
  }
  options.anytime |= arguments.anytime;
  options.without = parse_mechanisms(arguments.without);
  options.validate(*task.model);
  const fs::path dir = task_dir(arguments.out_dir, task.name, options.seed);
  const fs::path file = dir / "plan.json";
  tasks::require_writable(dir);  // before the work, not after it

  const auto findings = tasks::lint(task, control);
  print_warnings(findings);

  catch_signals();
  ProgressLine line;
  control.on_progress = [&line](const core::Progress& progress) { line.show(progress); };

  std::FILE* const to = people(arguments.json);
  const auto write = [&](const planning::PlanResult& found) { tasks::write_plan(tasks::make_plan_file(task, options, found, file), file); };
  const auto keep = [&](const planning::PlanResult& found) {  // usable while the search for a cheaper one goes on
    if (!options.anytime) return;
    write(found);
    line.clear();
    say(to, "  plan after {:.3f} s: cost {:.1f} s, {}{}\n", found.wall_s, found.cost, file.string(),
        found.improvements.size() == 1 ? "; looking for a cheaper one, press Ctrl-C to stop with the best plan" : "");
    std::fflush(to);
  };
  planning::PlanResult result;
  const Status status = planning::plan_watched(task.problem, {}, options, control, {}, result, keep);
  line.clear();
  if (const auto stuck = std::find_if(findings.begin(), findings.end(), [](const auto& f) { return f.kind == "stuck"; });
      status == Status::NumericalFailure && stuck != findings.end())
    throw core::InvalidInput(stuck->message);
  if (!result.improvements.empty()) result.status = Status::Solved;  // all that was interrupted is the search for a cheaper plan
  write(result);
  print_summary(to, task, options, result, file);
  if (arguments.profile) print_profile(to, result.profile);

  const fs::path html = dir / "plan.html";
  const bool shown = arguments.html && status != Status::Cancelled;
  const bool page_failed = shown && !make_page(file, html, to, "the plan itself is in " + file.string());
  const std::string page = shown && !page_failed ? html.string() : "";
  if (arguments.json) say(stdout, "{}\n", to_json(task, result, file, page, findings).dump());
  if (status == Status::Cancelled) return kInterrupted;
  if (status != Status::Solved) return kNotSolved;
  return page_failed ? kInternalError : kDone;
}

}  // namespace

Run declare_plan(CLI::App& command) {
  const auto arguments = std::make_shared<PlanArguments>();
  PlanArguments& a = *arguments;
  add_task(command, a.task);
  add_seed(command, a.seed, "Seed of the search; the same seed gives the same plan");
  add_goal(command, a.goal);
  add_timeout(command, a.timeout_s);
  add_threads(command, a.threads);
  add_scheme(command, a.scheme);
  command.add_option("--without", a.without, "Mechanisms of the search that are left out, with commas between (bench/search.py)")
      ->group("");
  add_out(command, a.out_dir, "Folder for plan.json (default ./TASK-seedN)");
  command.add_flag("--anytime", a.anytime, "Write the first plan at once, and search for cheaper plans until the time budget is used up");
  command.add_flag("--html", a.html, "Also write plan.html, a page that plays the plan");
  command.add_flag("--profile", a.profile, "Also print the processor time of each activity of the search (always part of --json)");
  add_json(command, a.json);
  return [arguments] { return run_plan(*arguments); };
}

}  // namespace stiction::app
