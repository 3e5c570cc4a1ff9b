#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "frames.hpp"
#include "guarded_report.hpp"
#include "run_command.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/closed_loop/handling.hpp"
#include "stiction/execution/closed_loop/part_start.hpp"
#include "stiction/execution/closed_loop/run.hpp"
#include "stiction/execution/closed_loop/simulated_plant.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/tasks/goals_in_row.hpp"
#include "stiction/tasks/lint.hpp"
#include "stiction/tasks/scenarios.hpp"
#include "stiction/tasks/touch_first.hpp"
#include "stiction/tasks/touch_scenario_file.hpp"
#include "stiction/tasks/unplanned.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;
using core::Status;
using execution::RunEnd;
using json = nlohmann::ordered_json;

struct RunArguments {
  std::string target;  ///< task or plan
  std::vector<std::string> goals;
  std::string goals_file;
  std::string touch_first;  ///< scenario of guarded moves
  std::optional<std::uint64_t> seed;
  double timeout_s = 300;
  std::vector<double> noise;          ///< of poses: [m], [rad]
  std::vector<std::string> pushes{};  ///< from outside
  execution::RunOptions how;
  execution::WorldOptions world;
  std::optional<int> threads;
  std::string out_dir;
  bool active_hold = false;
  bool no_finger_gait = false;
  bool no_join = false;
  bool html = false;
  bool json = false;
};

/// What is run: a task, and the plan to begin with where one was given.
struct Given {
  tasks::Task task;
  std::optional<tasks::PlanFile> file;
  planning::Plan plan;
  planning::PlannerOptions options;
  std::vector<planning::PlanningProblem> later;  ///< goals after that of the task
  std::shared_ptr<const world::Model> world;     ///< what is simulated; null: what is known
};

bool is_plan(const std::string& target) { return target.ends_with(".json") || fs::is_directory(target); }

/// The goals of the command line: the first one is that of the task, the others come after it.
void set_goals(const RunArguments& arguments, Given& given) {
  const std::string option = arguments.goals_file.empty() ? "--goal" : "--goals";
  if (arguments.goals.empty() && arguments.goals_file.empty()) return;
  if (!arguments.goals.empty() && !arguments.goals_file.empty()) core::throw_invalid("--goals", "a file beside --goal", "one of the two");
  if (given.file) core::throw_invalid(option, "a goal with a plan", "none: a plan has its own");
  std::vector<planning::PlanningProblem> goals;
  if (arguments.goals_file.empty()) {
    std::vector<std::vector<std::optional<double>>> numbers;
    for (const std::string& goal : arguments.goals) numbers.push_back(parse_numbers("--goal", goal));
    goals = tasks::make_goals(given.task, numbers, "--goal");
  } else {
    goals = tasks::load_goals(given.task, arguments.goals_file);
  }
  if (goals.size() > 1 && !arguments.touch_first.empty())
    core::throw_invalid("--touch-first", fmt::format("{} goals", goals.size()), "one goal");
  given.task.problem = std::move(goals.front());
  given.task.goal_from_command_line = true;
  goals.erase(goals.begin());
  given.later = std::move(goals);
}

Given load(const RunArguments& arguments) {
  Given out;
  if (is_plan(arguments.target)) {
    const fs::path path = arguments.target;
    out.file = tasks::read_plan(path);
    out.task = tasks::load_task_of_plan(*out.file, path, data_dirs());
    out.plan = tasks::to_plan(*out.task.model, *out.file);
    out.options = tasks::options_of_plan(*out.task.model, *out.file, path);
    out.task.problem.goal = out.plan.goal;
  } else {
    out.task = tasks::load_task(arguments.target, data_dirs());
    out.options = out.task.options;
  }
  set_goals(arguments, out);
  out.options.seed = arguments.seed.value_or(out.options.seed);
  out.options.threads = arguments.threads.value_or(0);
  return out;
}

/// "BEGIN DURATION FX FY FZ", on the object of the goal.
execution::OutsidePush parse_push(const std::string& text, int object) {
  const auto numbers = parse_numbers("--push", text);
  if (numbers.size() != 5 || !std::ranges::all_of(numbers, [](const auto& x) { return x.has_value(); }))
    core::throw_invalid("--push", fmt::format("'{}'", text), "five numbers: begin [s], duration [s] and force x y z [N]");
  return {object, *numbers[0], *numbers[1], Eigen::Vector3d(*numbers[2], *numbers[3], *numbers[4])};
}

/// Guarded moves before the run.
struct Felt {
  execution::TouchScenario scenario;
  execution::GuardedRunResult result;
  bool gentle = false;
  double wall_s = 0;
};

constexpr double kGentle = 0.2;  ///< share by which forces may exceed what is asked, as of stiction touch

/// What is felt corrects the task; the run goes on in the world of the moves.
Felt feel(const RunArguments& arguments, const core::RunControl& control, Given& given) {
  const auto started = core::RunControl::Clock::now();
  Felt out;
  if (given.file) tasks::set_start(given.task, execution::start_of(*given.task.model, given.plan));
  out.scenario = tasks::load_touch_scenario(tasks::find_scenario(arguments.touch_first, data_dirs()), given.task);
  execution::TouchRunOptions options;
  options.seed = given.options.seed;
  options.control = control;
  (void)tasks::touch_first(out.scenario, arguments.world, options, given.task, out.result);  // the status is in the result
  given.world = out.result.world;
  out.gentle = is_gentle(out.scenario, out.result, kGentle);
  out.wall_s = core::seconds_since(started);
  return out;
}

/// Where the plant begins: at the start of the task or plan, with what overlaps there moved apart, or where guarded moves left off.
execution::PartedStart start_of(const Given& given) {
  const world::Model& model = *given.task.model;
  if (given.world) return {.q = given.task.problem.q_start};
  const Eigen::VectorXd q = given.file ? execution::start_of(model, given.plan) : given.task.problem.q_start;
  return execution::part_start(given.task.model, q, given.options.step_options(model));
}

/// The plant, and what the page needs of every look.
class Recorder {
 public:
  Recorder(const Given& given, const RunArguments& arguments)
      : start(start_of(given)),
        plant(given.world ? given.world : given.task.model, start.q, arguments.world),
        model_(*given.task.model),
        watch_(plant),
        goals_(1 + given.later.size()),
        keeps_(arguments.html || !arguments.out_dir.empty()) {}

  void take(const execution::RunSample& sample) {
    watch_.take(sample);
    if (keeps_) {
      forces_.push_back(plant.world().forces());
      torques_.push_back(plant.take_torques());
    }
    line.show(fmt::format("{:6.2f} s  {:7}  {} plans, {} pieces   {:.3g} tolerances from {}", sample.time,
                          execution::to_string(sample.state), sample.plans, sample.piece + 1, sample.goal_share,
                          goals_ > 1 ? fmt::format("goal {} of {}", sample.goal + 1, goals_) : "the goal"));
  }
  execution::Handling handling() const { return watch_.result(); }
  const std::vector<std::vector<simulation::PairForce>>& forces() const { return forces_; }  ///< per look
  Eigen::MatrixXd torque() const {                                                           ///< (n_a × looks), as in Recording
    Eigen::MatrixXd out(model_.n_a(), static_cast<Eigen::Index>(torques_.size()));
    for (std::size_t k = 0; k < torques_.size(); ++k) out.col(static_cast<Eigen::Index>(k)) = torques_[k];
    return out;
  }

  const execution::PartedStart start;
  execution::SimulatedPlant plant;
  ProgressLine line;

 private:
  const world::Model& model_;
  execution::HandlingWatch watch_;
  std::size_t goals_;
  bool keeps_;
  std::vector<std::vector<simulation::PairForce>> forces_;
  std::vector<Eigen::VectorXd> torques_;
};

json to_json(const planning::GoalError& error) { return {{"position", error.position}, {"angle", error.angle}}; }

/// That which a run was on its way to at its end.
const planning::Goal& last_goal(const Given& given, const execution::RunResult& r) {
  return r.goals.size() < 2 ? given.task.problem.goal : given.later[r.goals.size() - 2].goal;
}

json report(const Given& given, const RunArguments& arguments, const execution::RunResult& r, const Recorder& recorder) {
  const planning::Goal& goal = last_goal(given, r);
  json out;
  out["status"] = execution::to_string(r.end);
  out["task"] = given.task.name;
  out["seed"] = given.options.seed;
  out["mode"] = "closed loop";
  out["wall_s"] = r.wall_s;
  out["planning_s"] = r.planning_s;
  out["duration_s"] = r.duration_s;
  out["message"] = r.message;
  out["reached"] = r.reached();
  out["error"] = to_json(r.error);
  out["true_error"] = to_json(planning::goal_error(*given.task.model, recorder.plant.world().q(), goal));
  out["tolerance"] = {{"position", goal.tol_position}, {"angle", goal.tol_angle}};
  out["pushes"] = r.count(planning::SegmentKind::Contact);
  out["regrasps"] = r.count(planning::SegmentKind::Regrasp);
  out["replans"] = r.replans;
  out["dropped"] = r.dropped ? json(given.task.model->objects()[static_cast<std::size_t>(*r.dropped)].name) : json();
  out["dropped_s"] = r.dropped ? json(r.duration_s) : json();
  out["start_overlap"] = recorder.start.overlap;
  out["start_moved"] = recorder.start.moved;
  out["max_penetration"] = recorder.plant.world().max_depth();
  out["largest_effort"] = recorder.plant.world().largest_effort();
  const execution::Handling handling = recorder.handling();
  out["largest_press"] = handling.force ? json(*handling.force) : json();
  out["slip_speed"] = handling.force ? json(handling.slip_speed()) : json();
  out["world"] = {{"friction", arguments.world.friction},     {"mass", arguments.world.mass},
                  {"pose_noise", arguments.world.pose_noise}, {"angle_noise", arguments.world.angle_noise},
                  {"pose_delay", arguments.world.pose_delay}, {"pushes", arguments.world.pushes.size()}};
  out["goals_given"] = 1 + given.later.size();
  out["goals_reached"] = r.goals_reached();
  out["goals"] = json::array();
  for (const auto& one : r.goals) {
    out["goals"].push_back({{"reached", one.reached},
                            {"begin_s", one.begin_s},
                            {"end_s", one.end_s},
                            {"error", to_json(one.error)},
                            {"replans", one.replans}});
  }
  out["plans"] = json::array();
  for (const auto& plan : r.plans) {
    out["plans"].push_back({{"time_s", plan.time},
                            {"wall_s", plan.wall_s},
                            {"processor_s", plan.processor_s},
                            {"clock_s", plan.clock_s},
                            {"joined", plan.joined},
                            {"status", core::to_string(plan.status)},
                            {"cause", plan.cause},
                            {"reason", plan.reason.empty() ? json() : json(plan.reason)}});
  }
  out["pieces"] = json::array();
  for (const auto& piece : r.pieces) {
    out["pieces"].push_back({{"kind", kKinds[static_cast<std::size_t>(piece.kind)]},
                             {"plan", piece.plan},
                             {"begin_s", piece.begin_s},
                             {"end_s", piece.end_s},
                             {"off", piece.off},
                             {"given_up", piece.given_up}});
  }
  return out;
}

/// What was done to a start that overlaps.
void print_start(std::FILE* to, const world::Model& model, const execution::PartedStart& start) {
  if (start.pair < 0) return;
  const auto& pair = model.pairs()[static_cast<std::size_t>(start.pair)];
  const auto name = [&](int geometry) { return model.geometries()[static_cast<std::size_t>(geometry)].name; };
  print_row(to, "start",
            fmt::format("'{}' and '{}' overlapped by {:.2g} mm; an object was moved by {:.2g} (m or rad) to separate them",
                        name(pair.geometry_a), name(pair.geometry_b), 1e3 * start.overlap, start.moved));
}

void print_summary(std::FILE* to, const Given& given, const execution::RunResult& r, const json& out) {
  const auto row = [to](std::string_view name, const std::string& value) { print_row(to, name, value); };
  const planning::Goal& goal = last_goal(given, r);
  const std::size_t goals = 1 + given.later.size();
  const std::string reached = goals > 1 ? fmt::format("{} goals reached", goals) : "goal reached";
  say(to, "{}, seed {}: run in closed loop: {}\n", given.task.name, given.options.seed, r.reached() ? reached : r.message);
  if (goals > 1) {
    row("goals", fmt::format("{} of {} reached", r.goals_reached(), goals));
    for (std::size_t i = 0; i < r.goals.size(); ++i)
      row("", fmt::format("{:6.2f} s: goal {} {}", r.goals[i].end_s, i + 1, r.goals[i].reached ? "reached" : "not reached"));
  }
  double thought = 0;
  for (const auto& plan : r.plans) thought += plan.clock_s;
  row("time", fmt::format("{:.2f} s simulated, of which the planner took {:.2f} s", r.duration_s, thought));
  row("error at the goal", fmt::format("{:.2f} mm (tolerance {:.0f}), {:.4f} rad (tolerance {:.2f})", 1e3 * r.error.position,
                                       1e3 * goal.tol_position, r.error.angle, goal.tol_angle));
  row("executed", fmt::format("{} pushes, {} regrasps", out["pushes"].get<long>(), out["regrasps"].get<long>()));
  const auto joined = std::count_if(r.plans.begin(), r.plans.end(), [](const auto& plan) { return plan.joined; });
  row("plans", fmt::format("{}, of which {} are replans and {} continue the plan before", r.plans.size(), r.replans, joined));
  for (std::size_t i = 1; i < r.plans.size(); ++i)
    row("", fmt::format("{:6.2f} s: {}{}", r.plans[i].time, r.plans[i].cause, r.plans[i].reason.empty() ? "" : "; " + r.plans[i].reason));
  if (!out["largest_press"].is_null())
    row("object", fmt::format("contact force at most {:.1f} times its weight; at most {:.3f} m/s faster than planned",
                              out["largest_press"].get<double>(), out["slip_speed"].get<double>()));
  row("largest effort", fmt::format("{:.0f} % of the limit of the motor", 1e2 * out["largest_effort"].get<double>()));
}

/// Of an object that fingers turned without a plan: where that began, and the command that was in force.
std::optional<planning::PlanResult> turned_in_hand(const Given& given, const execution::RunResult& r) {
  if (r.pieces.empty() || r.q.cols() == 0) return std::nullopt;
  tasks::Task task = given.task;
  task.options = given.options;
  task.problem.q_start = r.q.col(0);
  planning::PlanResult out = tasks::make_commanded(task, Eigen::MatrixXd(r.u.rows(), 0), r.u.col(0));
  out.seed = given.options.seed;
  return out;
}

/// Plan, run and page. @returns whether all that was asked for could be written
bool write(const Given& given, const execution::RunResult& r, const Recorder& recorder, const RunArguments& arguments, const fs::path& dir,
           std::FILE* to, json& out) {
  std::optional<tasks::PlanFile> file = given.world ? std::nullopt : given.file;
  fs::path plan = file ? fs::path(arguments.target) : dir / (given.file ? "felt_plan.json" : "plan.json");
  const std::optional<planning::PlanResult> first = r.first_plan ? r.first_plan : turned_in_hand(given, r);
  if (!file && first) {
    planning::PlannerOptions options = given.options;
    file = tasks::make_plan_file(given.task, options, *first, plan);
    tasks::write_plan(*file, plan);
  }
  if (!file) {
    say(stderr, "stiction: the run made no plan, so no files are written\n");
    return !arguments.html;
  }
  const fs::path target = dir / "run.json";
  write_simulation(*given.task.model, *file, out, {r.times, r.piece, r.q, r.q_plan, recorder.forces(), recorder.torque()}, target);
  print_row(to, "run", target.string());
  out["plan"] = plan.string();
  out["run"] = target.string();
  if (!arguments.html || r.end == RunEnd::Cancelled) return true;
  const fs::path html = dir / "run.html";
  if (!make_page(plan, html, to, "the run itself is in " + target.string(), target)) return false;
  out["page"] = html.string();
  return true;
}

/// Guarded moves that did not end as they should: the run does not begin.
int end_unfelt(const Given& given, const RunArguments& arguments, const Felt& felt) {
  if (arguments.json) {
    const json out{{"status", execution::to_string(RunEnd::Unfelt)},
                   {"task", given.task.name},
                   {"seed", given.options.seed},
                   {"mode", "closed loop"},
                   {"message", fmt::format("before the run: {}", felt.result.reason)},
                   {"reached", false},
                   {"touch", report_moves(felt.scenario, felt.result, given.options.seed, felt.gentle, felt.wall_s)}};
    say(stdout, "{}\n", out.dump());
  }
  return felt.result.status == Status::Cancelled ? kInterrupted : kNotSolved;
}

/// The plan that a run begins with; null: it plans, also where a given one knows nothing of what was felt.
const planning::Plan* first_plan(const Given& given) { return given.file && !given.world ? &given.plan : nullptr; }

int run_run(RunArguments arguments) {
  Given given = load(arguments);
  print_notes(given.task);
  if (!arguments.noise.empty()) {
    arguments.world.pose_noise = arguments.noise[0];
    arguments.world.angle_noise = arguments.noise[1];
  }
  arguments.world.seed = given.options.seed;
  arguments.how.active_hold = arguments.active_hold;
  arguments.how.finger_gait = !arguments.no_finger_gait;
  arguments.how.join = !arguments.no_join;
  for (const std::string& text : arguments.pushes) arguments.world.pushes.push_back(parse_push(text, given.task.problem.goal.object));
  const fs::path dir =
      given.file ? plan_dir(arguments.out_dir, arguments.target) : task_dir(arguments.out_dir, given.task.name, given.options.seed);
  const bool writes = arguments.html || !arguments.out_dir.empty();
  if (writes) tasks::require_writable(dir);

  core::RunControl control = make_run_control(arguments.timeout_s);
  std::FILE* const to = people(arguments.json);
  std::optional<Felt> felt;
  if (!arguments.touch_first.empty()) {
    catch_signals();
    felt = feel(arguments, control, given);
    print_moves(to, felt->scenario, felt->result, felt->gentle);
    if (!felt->result.reached) return end_unfelt(given, arguments, *felt);
  }
  print_warnings(tasks::lint(given.task, control));
  catch_signals();
  Recorder recorder(given, arguments);
  arguments.how.on_sample = [&recorder](const execution::RunSample& sample) { recorder.take(sample); };
  control.on_progress = [&recorder](const core::Progress& progress) { recorder.line.show(progress); };
  execution::RunResult result;
  std::vector<planning::PlanningProblem> goals{given.task.problem};
  goals.insert(goals.end(), given.later.begin(), given.later.end());
  const Status status = execution::run(recorder.plant, goals, given.options, arguments.how, control, result, first_plan(given));
  recorder.line.clear();

  json out = report(given, arguments, result, recorder);
  if (felt) out["touch"] = report_moves(felt->scenario, felt->result, given.options.seed, felt->gentle, felt->wall_s);
  print_summary(to, given, result, out);
  print_start(to, *given.task.model, recorder.start);
  const bool written = !writes || write(given, result, recorder, arguments, dir, to, out);
  if (arguments.json) say(stdout, "{}\n", out.dump());
  if (status == Status::Cancelled) return kInterrupted;
  if (!written || result.end == RunEnd::Silent) return kInternalError;
  return result.reached() ? kDone : kNotSolved;
}

}  // namespace

Run declare_run(CLI::App& command) {
  const auto arguments = std::make_shared<RunArguments>();
  RunArguments& a = *arguments;
  command.add_option("target", a.target, "Name of a built-in task, a task file (.yaml), a plan file (.json) or its folder")->required();
  command
      .add_option(
          "--goal", a.goals,
          "Goal pose, instead of the goal of the task: \"x y z roll pitch yaw\" [m, rad] for a free object, else the coordinates of its "
          "joints; ~ leaves a coordinate open. If repeated, the goals are reached one after another")
      ->allow_extra_args(false);
  command.add_option(
      "--goals", a.goals_file,
      "YAML file with a list of goals that are reached one after another; each goal is a list of numbers, or has the form of `goal` in a "
      "task");
  add_number(command, "--hold", a.how.hold,
             "Time for which the object must stay within the tolerances of a goal before the goal counts as reached [s]; with 0, the goal "
             "counts as soon as the object is seen there",
             Bound::NonNegative);
  command.add_option(
      "--touch-first", a.touch_first,
      "Name or file of a scenario of guarded moves, with the key `task`. The arm executes them first, and corrects the scene by the "
      "contacts that it feels");
  add_seed(command, a.seed, "Seed of the plans and of the noise");
  add_timeout(command, a.timeout_s, "Wall-clock budget of the run [s]");
  add_threads(command, a.threads);
  add_integer(command, "--replans", a.how.replans, "Largest number of plans per goal after its first plan", {0, 1000000});
  add_number(command, "--duration", a.how.duration, "Largest simulated time of the run, for all goals together [s]", Bound::Positive);
  add_number(
      command, "--planning-rate", a.how.planning_rate,
      "Processor time of the planner per simulated second [s], on one core; with 0, the simulated clock stands still while the planner "
      "works",
      Bound::NonNegative);
  add_number(command, "--plan-step-time", a.how.plan_step_time,
             "Time to charge for each simulation step of the planner [s], instead of its processor time. A run is then the same on every "
             "machine",
             Bound::Positive);
  command.add_flag("--active-hold", a.active_hold, "Let the fingers of a hand keep a free object in place while no plan is executed");
  command.add_flag(
      "--no-finger-gait", a.no_finger_gait,
      "Plan also for an object that would roll out of an open hand, instead of turning it with fingers that move back one by one");
  command.add_flag("--no-join", a.no_join, "Search for every plan from scratch, and never continue the plan before it");
  add_speed(command, a.how.speed_factor);
  add_number(command, "--friction", a.world.friction, "Factor on every coefficient of friction in the simulation", Bound::NonNegative);
  add_number(command, "--mass", a.world.mass, "Factor on the mass of every object in the simulation", Bound::Positive);
  add_numbers(command, "--pose-noise", a.noise,
              "Standard deviations of the noise on measured object poses, \"M,RAD\": position [m], angle [rad]", Bound::NonNegative, 2);
  add_number(command, "--pose-delay", a.world.pose_delay, "Delay of the measured object poses [s]", Bound::NonNegative);
  command.add_option("--push", a.pushes, "External force on the object of the goal, \"BEGIN DURATION FX FY FZ\" [s], [N]; may be repeated")
      ->allow_extra_args(false);
  add_out(command, a.out_dir, "Folder for plan.json, run.json and the page (default with --html: ./TASK-seedN, or the folder of the plan)");
  command.add_flag("--html", a.html, "Also write run.html, a page that plays the run");
  add_json(command, a.json);
  return [arguments] { return run_run(*arguments); };
}

}  // namespace stiction::app
