#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "frames.hpp"
#include "open_loop_speed.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/open_loop/transfer.hpp"
#include "stiction/tasks/plan_file.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;
using core::Status;
using json = nlohmann::ordered_json;

struct SimulateArguments {
  std::string plan;
  std::string out_dir;
  double timeout_s = 600;
  double speed = execution::kOpenLoopSpeed;  ///< times the full speed
  double pause_s = 0;                        ///< between pieces
  std::optional<int> substeps;               ///< predict each edge in this many steps; nothing: as the plan does
  double rest_time_s = execution::kRestTime;
  double friction_scale = 1;
  bool velocity_reference = true;  ///< of the commands, for the damping of the joint springs
  bool whole_only = false;         ///< pushes are not run by themselves as well
  std::optional<int> threads;
  bool html = false;
  bool json = false;
};

json optional_number(const std::optional<double>& value) { return value ? json(*value) : json(); }

json to_json(const std::optional<execution::PieceError>& error) {
  if (!error) return {};
  const execution::PieceError& e = *error;
  return {{"mean_position", e.mean_position},
          {"mean_angle", e.mean_angle},
          {"length_position", e.length_position},
          {"length_angle", e.length_angle},
          {"normalised_position", optional_number(e.normalised_position())},
          {"normalised_angle", optional_number(e.normalised_angle())},
          {"start_position", e.start_position},
          {"start_angle", e.start_angle},
          {"end_position", e.end_position},
          {"end_angle", e.end_angle}};
}

/// Of a run to its end: reached or missed, or that the plan itself ends elsewhere.
std::string_view verdict_of(const tasks::PlanFile& plan, const execution::TransferResult& r) {
  if (r.status != Status::Solved) return core::to_string(r.status);
  if (r.reached) return "Reached";
  return plan.status == Status::Solved ? "Missed" : "NotSolved";
}

/// What is printed with --json, and the head of the file that the page is made of.
json report(const tasks::PlanFile& plan, const world::Model& model, const execution::TransferResult& r,
            const SimulateArguments& arguments) {
  json out;
  out["status"] = verdict_of(plan, r);
  out["plan_status"] = core::to_string(plan.status);
  out["task"] = plan.task_name;
  out["seed"] = plan.seed;
  out["wall_s"] = r.wall_s;
  out["steps"] = r.steps;
  out["duration_s"] = r.duration_s;
  out["message"] = r.message;
  out["reached"] = r.reached;
  out["error"] = {{"position", r.error.position}, {"angle", r.error.angle}};
  out["dropped"] = r.dropped ? json(model.objects()[static_cast<std::size_t>(*r.dropped)].name) : json();
  out["dropped_s"] = r.dropped ? json(r.dropped_s) : json();
  out["max_penetration"] = r.max_depth;
  out["speed"] = arguments.speed;
  out["prediction_substeps"] = arguments.substeps.value_or(0);
  out["pieces"] = json::array();
  for (const auto& piece : r.pieces) {
    json entry;
    entry["kind"] = kKinds[static_cast<std::size_t>(piece.kind)];
    entry["segments"] = {piece.first_segment, piece.last_segment};
    entry["begin_s"] = piece.begin_s;
    entry["end_s"] = piece.end_s;
    entry["in_plan"] = to_json(piece.in_plan);
    entry["alone"] = to_json(piece.alone);
    out["pieces"].push_back(std::move(entry));
  }
  return out;
}

void print_error(std::FILE* to, const std::optional<execution::PieceError>& error) {
  if (!error) {
    say(to, " {:>33}", "not reached");
    return;
  }
  const execution::PieceError& e = *error;
  const auto share = [](const std::optional<double>& x) { return x ? fmt::format("{:7.3f}", *x) : std::string("      –"); };
  say(to, " {:7.2f} {} {:8.4f} {}", 1e3 * e.mean_position, share(e.normalised_position()), e.mean_angle, share(e.normalised_angle()));
}

void print_summary(std::FILE* to, const tasks::PlanFile& plan, const world::Model& model, const execution::TransferResult& r,
                   const execution::TransferOptions& options) {
  say(to, "{}, seed {}: {} open loop: {}\n", plan.task_name, plan.seed, "simulated",
      r.status != Status::Solved ? std::string(core::to_string(r.status))
      : r.reached                ? "goal reached"
                                 : "goal missed");
  if (!r.message.empty()) print_row(to, "simulation", r.message);
  const auto row = [to](std::string_view name, const std::string& value) { print_row(to, name, value); };
  row("time",
      fmt::format("{:.1f} s{} simulated in {:.2f} s", r.duration_s,
                  r.dropped && !r.pieces.empty() ? fmt::format(" of {:.1f} s", r.pieces.back().end_s + options.hold) : "", r.wall_s));
  row("speed", describe_speed(options.speed));
  row("error at the goal", fmt::format("{:.2f} mm (tolerance {:.0f}), {:.4f} rad (tolerance {:.2f})", 1e3 * r.error.position,
                                       1e3 * plan.tol_position, r.error.angle, plan.tol_angle));
  row("deepest penetration", fmt::format("{:.3f} mm", 1e3 * r.max_depth));
  row("dropped",
      r.dropped ? fmt::format("{} after {:.2f} s", model.objects()[static_cast<std::size_t>(*r.dropped)].name, r.dropped_s) : "nothing");
  say(to, "  mean error Δ of the object in each push and regrasp, and its ratio to the length L of the planned path:\n");
  say(to, "  {:12} {:>7}   {:^33} {:^33}\n", "piece", "end s", "whole plan: mm, Δ/L, rad, Δ/L", "by itself: mm, Δ/L, rad, Δ/L");
  for (std::size_t i = 0; i < r.pieces.size(); ++i) {
    const auto& piece = r.pieces[i];
    say(to, "  {:3} {:8} {:7.2f}  ", i,
        piece.kind == planning::SegmentKind::Contact ? "push" : kKinds[static_cast<std::size_t>(piece.kind)], piece.end_s);
    print_error(to, piece.in_plan);
    if (piece.alone) print_error(to, piece.alone);
    say(to, "\n");
  }
}

std::shared_ptr<const simulation::Plant> make_plant(const std::shared_ptr<const world::Model>& model, const tasks::PlanFile& file,
                                                    const SimulateArguments& arguments) {
  simulation::PlantOptions options;
  options.rest_time = arguments.rest_time_s;
  options.velocity_reference = arguments.velocity_reference;
  options.effort_limits = file.step.effort_limits;
  options.contact.friction_scale = arguments.friction_scale;
  return simulation::Plant::make(model, options);
}

int run_simulate(const SimulateArguments& arguments) {
  const core::RunControl control = make_run_control(arguments.timeout_s);  // what is read counts too
  const fs::path path = arguments.plan;
  const tasks::PlanFile file = tasks::read_plan(path);
  const tasks::Task task = tasks::load_task_of_plan(file, path, data_dirs());
  planning::Plan plan = tasks::to_plan(*task.model, file);
  const fs::path dir = plan_dir(arguments.out_dir, path);
  const bool writes = arguments.html || !arguments.out_dir.empty();
  if (writes) tasks::require_writable(dir);

  execution::TransferOptions options;
  options.speed = arguments.speed;
  options.pause = arguments.pause_s;
  options.alone = !arguments.whole_only;
  options.threads = arguments.threads.value_or(0);
  const auto plant = make_plant(task.model, file, arguments);
  planning::Plan predicted;
  if (arguments.substeps) {
    if (execution::predict(*task.model, plan, *arguments.substeps, predicted) != Status::Solved)
      say(stderr, "stiction: the prediction with {} steps per edge stops in edge {}, because a step has no solution\n", *arguments.substeps,
          predicted.segments.size());
    plan.segments.resize(predicted.segments.size());  // what was predicted is run and compared
  }

  if (file.status != Status::Solved)
    fmt::print(
        stderr,
        "stiction: warning: {}: the plan does not reach its goal (status {}); a longer search may reach it (`stiction plan --timeout`)\n",
        path.string(), core::to_string(file.status));
  catch_signals();
  ProgressLine line;
  line.show(fmt::format("simulating {} segments", plan.segments.size()));
  execution::TransferResult result;
  const Status status = execution::transfer(plant, plan, options, control, result, arguments.substeps ? &predicted : nullptr);
  line.clear();
  std::FILE* const to = people(arguments.json);
  print_summary(to, file, *task.model, result, options);

  json out = report(file, *task.model, result, arguments);
  bool page_failed = false;
  if (writes) {
    const fs::path target = dir / "simulation.json";
    write_simulation(*task.model, file, out, {result.times, result.piece, result.q, result.q_plan, result.forces, result.torque}, target);
    print_row(to, "simulation", target.string());
    out["simulation"] = target.string();
    if (arguments.html && status == Status::Solved) {
      const fs::path html = dir / "simulation.html";
      page_failed = !make_page(path, html, to, "the simulation itself is in " + target.string(), target);
      if (!page_failed) out["page"] = html.string();
    }
  }
  if (arguments.json) say(stdout, "{}\n", out.dump());
  const ExitCode code = exit_code(status, page_failed, result.reached);
  return code == kCheckFailed && file.status != Status::Solved ? kNotSolved : code;
}

}  // namespace

Run declare_simulate(CLI::App& command) {
  const auto arguments = std::make_shared<SimulateArguments>();
  SimulateArguments& a = *arguments;
  add_plan(command, a.plan);
  add_out(command, a.out_dir, "Folder for simulation.json and the page (default: the folder of the plan)");
  add_timeout(command, a.timeout_s);
  add_threads(command, a.threads);
  add_open_loop_speed(command, a.speed);
  add_number(command, "--pause", a.pause_s, "Time of constant commands between pushes and regrasps [s]", Bound::NonNegative);
  add_integer(
      command, "--sub-steps", a.substeps,
      "Number of steps in which every edge of the plan is predicted again before the comparison; 1 as in the thesis (default: as in the "
      "plan)",
      {1, 10000});
  add_number(command, "--rest-time", a.rest_time_s, "Time constant with which objects on joints come to rest [s]", Bound::Positive);
  add_number(command, "--friction", a.friction_scale, "Factor on every coefficient of friction in the simulation", Bound::NonNegative);
  command.add_flag("!--no-velocity-reference", a.velocity_reference,
                   "Damp the velocity of each joint, instead of its difference from the commanded velocity. Joints then lag behind their "
                   "commands, as in "
                   "the thesis");
  command.add_flag("--whole-only", a.whole_only, "Simulate only the whole plan, and not also every push by itself");
  command.add_flag("--html", a.html, "Also write simulation.html, a page that plays the simulation");
  add_json(command, a.json);
  return [arguments] { return run_simulate(*arguments); };
}

}  // namespace stiction::app
