#include <fmt/format.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>

#include <limits>

#include "bind_run.hpp"
#include "bind_touch.hpp"
#include "own_plant.hpp"
#include "pickles.hpp"
#include "plan.hpp"
#include "planner_options.hpp"
#include "stiction/execution/closed_loop/handling.hpp"
#include "stiction/execution/closed_loop/part_start.hpp"
#include "stiction/execution/closed_loop/run.hpp"
#include "stiction/execution/closed_loop/simulated_plant.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/tasks/goals_in_row.hpp"
#include "stiction/tasks/scene_text.hpp"
#include "stiction/tasks/touch_first.hpp"
#include "stiction/tasks/touch_scenario_file.hpp"
#include "watcher.hpp"
#include "yaml_text.hpp"

namespace stiction::python {
namespace {

using execution::OutsidePush;
using execution::RunEnd;
using execution::RunGoal;
using execution::RunOptions;
using execution::RunPiece;
using execution::RunPlan;
using execution::RunResult;
using execution::RunState;
using execution::WorldOptions;

using Target = std::variant<std::shared_ptr<tasks::Task>, std::shared_ptr<Plan>>;
/// (begin [s], duration [s], force [N])
using PushLike = std::tuple<double, double, Vector>;

/// RunSample on its own, and what the simulated world feels at that moment.
struct Look {
  double time = 0;
  RunState state = RunState::Hold;
  Eigen::VectorXd q, q_plan, u;
  int piece = -1, plans = 0;
  double goal_share = 0;
  int goal = 0;
  Eigen::VectorXd torque;                       ///< empty of a plant of one's own
  std::vector<simulation::PairForce> forces{};  ///< … likewise
};

using OnSample = std::optional<nb::typed<nb::callable, void(Look)>>;

Look look_at(const execution::RunSample& sample, execution::SimulatedPlant* simulated) {
  Look out{sample.time, sample.state, sample.q, sample.q_plan, sample.u, sample.piece, sample.plans, sample.goal_share,
           sample.goal, {},           {}};
  if (simulated == nullptr) return out;
  out.torque = simulated->take_torques();
  out.forces = simulated->world().forces();
  return out;
}

using TouchFirst = std::variant<std::string, std::filesystem::path, execution::TouchScenario>;

/// A run and what the simulated world knows of it.
struct RunOutcome {
  RunResult result;
  std::optional<GuardedResult> touch;  ///< guarded moves before it
  planning::GoalError true_error;
  double start_overlap = 0, start_moved = 0;
  double max_depth = std::numeric_limits<double>::quiet_NaN(), largest_effort = max_depth;
  execution::Handling handling;
};

WorldOptions world_of(int object, double friction, double mass, std::pair<double, double> noise, double delay,
                      const std::vector<PushLike>& pushes, std::uint64_t seed) {
  WorldOptions out{friction, mass, noise.first, noise.second, delay, seed, {}};
  for (const auto& [begin, duration, force] : pushes) out.pushes.push_back({object, begin, duration, require_vector3("force", force)});
  return out;
}

/// The scenario of moves before a run of the task; a file is read for its scene.
execution::TouchScenario scenario_of(const TouchFirst& first, const tasks::Task& task) {
  if (const auto* given = std::get_if<execution::TouchScenario>(&first)) {
    if (tasks::make_scene_text(*given->arm.model) != task.scene_text)
      core::throw_invalid("touch_first", fmt::format("a scenario with another scene than that of task '{}'", task.name),
                          "one with the key `task` that names this task, or a file");
    if (given->moves.empty()) core::throw_invalid("touch_first", "a scenario with a goal", "one with moves");
    execution::TouchScenario out = *given;
    out.arm.model = task.model;
    out.arm.objects = task.problem.q_start.head(task.model->n_qu());
    out.arm.start = task.problem.q_start.tail(task.model->n_a());
    return out;
  }
  const auto* name = std::get_if<std::string>(&first);
  const auto file = file_of(name ? ScenarioFile(*name) : ScenarioFile(std::get<std::filesystem::path>(first)));
  return tasks::load_touch_scenario(file, task);
}

/// Carries out the moves and corrects the task. @returns whether the run may begin
bool feel(const TouchFirst& first, const WorldOptions& world, const core::RunControl& control, tasks::Task& task, RunOutcome& out) {
  const nb::gil_scoped_release unlocked;
  const execution::TouchScenario scenario = scenario_of(first, task);
  execution::TouchRunOptions options;
  options.seed = world.seed;
  options.control = control;
  GuardedResult& felt = out.touch.emplace();
  (void)tasks::touch_first(scenario, world, options, task, felt.result);  // the status is in the result
  name_moves(scenario, felt);
  if (felt.result.reached) return true;
  out.result.status = felt.result.status == core::Status::Solved ? core::Status::MaxIterations : felt.result.status;
  out.result.end = RunEnd::Unfelt;
  out.result.message = fmt::format("before the run: {}", felt.result.reason);
  return false;
}

using GoalsLike = std::optional<std::variant<std::string, std::filesystem::path, nb::sequence>>;

/// In place of the goal of the task.
std::vector<planning::PlanningProblem> goals_of(const tasks::Task& task, const GoalsLike& goals) {
  if (!goals) return {task.problem};
  if (const auto* list = std::get_if<nb::sequence>(&*goals)) return tasks::parse_goals(task, yaml_text(*list, "goals"), "goals");
  const auto* name = std::get_if<std::string>(&*goals);
  return tasks::load_goals(task, name ? std::filesystem::path(*name) : std::get<std::filesystem::path>(*goals));
}

std::unique_ptr<RunOutcome> run(const Target& target, const GoalsLike& goals_given, double hold, const nb::object& own_plant,
                                const std::optional<OptionsLike>& options, std::optional<std::uint64_t> seed, double speed, int replans,
                                double duration, double friction_scale, double mass_scale, std::pair<double, double> pose_noise,
                                double pose_delay, const std::vector<PushLike>& pushes, int threads, double timeout_s,
                                double plan_timeout_s, std::optional<double> plan_processor_s, double planning_rate,
                                std::optional<double> plan_step_time_s, bool active_hold, bool join, bool finger_gait,
                                const std::optional<TouchFirst>& touch_first, const Callback& on_progress, const OnSample& on_sample) {
  const auto* given = std::get_if<std::shared_ptr<Plan>>(&target);
  tasks::Task task = given ? (*given)->task : *std::get<std::shared_ptr<tasks::Task>>(target);
  planning::PlannerOptions planner = given ? tasks::options_of_plan(*task.model, (*given)->file, "plan") : task.options;
  if (options) planner = options_of({task.model, planner}, *options);
  planner.seed = seed.value_or(planner.seed);
  planner.threads = threads;
  std::optional<planning::Plan> plan;
  if (given) {
    plan = tasks::to_plan(*task.model, (*given)->file);
    task.problem.goal = plan->goal;
    task.problem.q_start = execution::start_of(*task.model, *plan);
  }
  if (given && goals_given) core::throw_invalid("goals", "goals with a plan", "None: a plan has its own");
  std::vector<planning::PlanningProblem> goals = goals_of(task, goals_given);
  if (goals.size() > 1 && touch_first) core::throw_invalid("touch_first", fmt::format("it with {} goals", goals.size()), "one goal");
  task.problem = goals.front();
  const int object = task.problem.goal.object;
  const WorldOptions differs = world_of(object, friction_scale, mass_scale, pose_noise, pose_delay, pushes, planner.seed);
  if (touch_first && !own_plant.is_none())
    core::throw_invalid("touch_first", "moves beside a plant of one's own", "plant=None: moves are carried out in the simulation");
  Watcher watcher(on_progress);
  const core::RunControl control = watcher.control(timeout_s);
  auto out = std::make_unique<RunOutcome>();
  if (touch_first) {
    plan.reset();  // it knows nothing of what is felt
    if (!feel(*touch_first, differs, control, task, *out)) {
      watcher.rethrow();
      return out;
    }
  }
  const world::Model& model = *task.model;
  goals.front() = task.problem;
  RunOptions how;
  how.hold = hold;
  how.replans = replans;
  how.duration = duration;
  how.plan_timeout = plan_timeout_s;
  how.plan_processor_time = plan_processor_s;
  how.planning_rate = planning_rate;
  how.active_hold = active_hold;
  how.finger_gait = finger_gait;
  how.join = join;
  how.plan_step_time = plan_step_time_s;
  how.speed_factor = speed;
  const Eigen::VectorXd& q_start = task.problem.q_start;
  const execution::PartedStart parted = own_plant.is_none() && !touch_first
                                            ? execution::part_start(task.model, q_start, planner.step_options(model))
                                            : execution::PartedStart{.q = q_start};
  execution::SimulatedPlant simulated(touch_first ? out->touch->result.world : task.model, parted.q, differs);
  OwnPlant own(own_plant);
  execution::Driver& plant = own_plant.is_none() ? static_cast<execution::Driver&>(simulated) : own;
  const auto start = core::RunControl::Clock::now();
  execution::HandlingWatch handling(simulated);
  how.on_sample = [&](const execution::RunSample& sample) {
    if (own_plant.is_none()) handling.take(sample);
    control.on_progress({.iteration = sample.plans,
                         .fraction = sample.time / duration,
                         .best = sample.goal_share,
                         .size = sample.piece + 1,
                         .cost = std::nullopt,
                         .elapsed_s = core::seconds_since(start)});
    if (on_sample) watcher.ask([&] { (*on_sample)(look_at(sample, own_plant.is_none() ? &simulated : nullptr)); });
  };
  out->start_overlap = parted.overlap;
  out->start_moved = parted.moved;
  {
    const nb::gil_scoped_release unlocked;
    (void)execution::run(plant, goals, planner, how, control, out->result, plan ? &*plan : nullptr);  // the status is in the result
  }
  watcher.rethrow();
  own.rethrow();
  if (!own_plant.is_none()) {
    out->true_error = out->result.error;
    return out;
  }
  const std::size_t begun = std::max<std::size_t>(1, out->result.goals.size());
  out->true_error = planning::goal_error(model, simulated.world().q(), goals[begun - 1].goal);
  out->max_depth = simulated.world().max_depth();
  out->largest_effort = simulated.world().largest_effort();
  out->handling = handling.result();
  return out;
}

void bind_parts(nb::module_& m) {
  nb::enum_<RunEnd>(m, "RunEnd", "Reason why a run ended.")
      .value("Reached", RunEnd::Reached, "the object stayed within the tolerances of the goal")
      .value("Dropped", RunEnd::Dropped, "an object fell")
      .value("NoPlan", RunEnd::NoPlan, "the planner found no plan, or refused the start")
      .value("Replans", RunEnd::Replans, "the run used up its `replans`")
      .value("TimeUp", RunEnd::TimeUp, "the `duration` by the clock of the plant is over")
      .value("Deadline", RunEnd::Deadline, "the wall time `timeout_s` is over")
      .value("Cancelled", RunEnd::Cancelled, "the caller stopped the run")
      .value("Silent", RunEnd::Silent, "the plant does not answer, or its objects are not seen any more")
      .value("Unfelt", RunEnd::Unfelt, "a guarded move before the run did not end as expected");
  nb::enum_<RunState>(m, "RunState", "Activity of a run at one moment.")
      .value("Hold", RunState::Hold, "the command is constant: objects come to rest, or the object has to stay at the goal")
      .value("Push", RunState::Push, "the robot pushes")
      .value("Regrasp", RunState::Regrasp, "the robot moves to new contacts")
      .value("Replan", RunState::Replan, "the command is constant while the planner works");
  nb::class_<Look>(m, "RunSample", "Measurement, command and activity of a run at one sample; a run takes 50 samples a second.")
      .def_ro("time", &Look::time, "since the start of the run [s]")
      .def_ro("state", &Look::state)
      .def_ro("q", &Look::q, "measured configuration (n_q)")
      .def_ro("q_plan", &Look::q_plan, "configuration that the plan predicts for this moment (n_q); equal to q if no plan is carried out")
      .def_ro("u", &Look::u, "commands (n_a) [rad or m]")
      .def_ro("piece", &Look::piece, "index into RunResult.pieces; -1 before the first piece")
      .def_ro("plans", &Look::plans, "number of plans so far")
      .def_ro("goal_share", &Look::goal_share, "distance of the object from the goal, in tolerances of the goal")
      .def_ro("goal", &Look::goal, "index of the current goal in `goals`")
      .def_ro("torque", &Look::torque,
              "largest torque of each motor since the previous sample (n_a) [N m or N]; empty if `plant` was given")
      .def_ro("forces", &Look::forces, "contact forces, one PairForce for each pair that touches; empty if `plant` was given");
  nb::class_<RunPlan>(m, "RunPlan", "One call of the planner in a run.")
      .def_ro("time", &RunPlan::time, "time of the run at which the planner was called [s]")
      .def_ro("wall_s", &RunPlan::wall_s, "wall time of the call [s]")
      .def_ro("processor_s", &RunPlan::processor_s, "processor time of the call on all cores of the process [s]")
      .def_ro("clock_s", &RunPlan::clock_s, "time that the call took by the clock of the plant [s]")
      .def_ro("status", &RunPlan::status)
      .def_ro("cause", &RunPlan::cause, "why the run called the planner")
      .def_ro("joined", &RunPlan::joined, "True: the run continued the previous plan, without a search")
      .def_ro("reason", &RunPlan::reason, "message of the planner if it found no plan");
  nb::class_<RunGoal>(m, "RunGoal", "One goal of a run.")
      .def_ro("reached", &RunGoal::reached)
      .def_ro("begin_s", &RunGoal::begin_s, "time of the run at which it became the current goal [s]")
      .def_ro("end_s", &RunGoal::end_s, "time of the run at which the goal counted as reached, or the run ended [s]")
      .def_ro("replans", &RunGoal::replans, "number of plans for this goal after the first one")
      .def_ro("error", &RunGoal::error, "measured distance from this goal at end_s");
  nb::class_<RunPiece>(m, "RunPiece", "One push or regrasp that a run carried out, whole or in part.")
      .def_ro("kind", &RunPiece::kind, "Contact or Regrasp")
      .def_ro("plan", &RunPiece::plan, "index into RunResult.plans; -1: the plan that was given, or no plan was needed yet")
      .def_ro("begin_s", &RunPiece::begin_s, "time of the run [s]")
      .def_ro("end_s", &RunPiece::end_s, "time of the run [s]")
      .def_ro("off", &RunPiece::off, "distance of the object from its planned path at the end, in tolerances of the goal")
      .def_ro("given_up", &RunPiece::given_up, "True: the run stopped the piece because the object was too far off its path");
}

}  // namespace

void bind_run(nb::module_& m) {
  bind_parts(m);
  bind_plants(m);
  const auto of = [](auto member) { return [member](const RunOutcome& r) { return r.result.*member; }; };
  nb::class_<RunOutcome>(m, "RunResult", "Result of run(): how the run ended, its plans, and the recorded motion.")
      .def_prop_ro("status", of(&RunResult::status), "Solved: all goals were reached")
      .def_prop_ro("end", of(&RunResult::end), "why the run ended")
      .def_prop_ro("message", of(&RunResult::message), "explanation in words if a goal was not reached")
      .def_prop_ro(
          "reached", [](const RunOutcome& r) { return r.result.reached(); }, "True: all goals were reached")
      .def_prop_ro("goals", of(&RunResult::goals), "goals that the run began, in their order")
      .def_prop_ro(
          "goals_reached", [](const RunOutcome& r) { return r.result.goals_reached(); }, "number of goals that were reached")
      .def_prop_ro("error", of(&RunResult::error), "measured distance of the object from the goal at the end")
      .def_ro("true_error", &RunOutcome::true_error,
              "exact distance from the goal in the simulation; equal to `error` if `plant` was given")
      .def_prop_ro(
          "touch", [](const RunOutcome& r) { return r.touch ? &*r.touch : nullptr; }, nb::rv_policy::reference_internal,
          "result of the guarded moves of `touch_first`; None: there were no moves")
      .def_prop_ro("duration_s", of(&RunResult::duration_s), "length of the run by the clock of the plant [s]")
      .def_prop_ro("planning_s", of(&RunResult::planning_s), "wall time of all plans [s]")
      .def_prop_ro("wall_s", of(&RunResult::wall_s), "wall time of the run [s]")
      .def_prop_ro("plans", of(&RunResult::plans), "calls of the planner")
      .def_prop_ro("pieces", of(&RunResult::pieces), "pushes and regrasps that were carried out")
      .def_prop_ro("replans", of(&RunResult::replans),
                   "number of plans after the first one of each goal; a plan that is asked for again after a refusal counts once")
      .def_prop_ro(
          "pushes", [](const RunOutcome& r) { return r.result.count(planning::SegmentKind::Contact); },
          "number of pushes that were carried out")
      .def_prop_ro(
          "regrasps", [](const RunOutcome& r) { return r.result.count(planning::SegmentKind::Regrasp); },
          "number of regrasps that were carried out")
      .def_prop_ro("dropped", of(&RunResult::dropped), "index of the object that fell, or None")
      .def_ro("max_depth", &RunOutcome::max_depth, "deepest penetration of any contact [m]; NaN if `plant` was given")
      .def_ro("start_overlap", &RunOutcome::start_overlap,
              "deepest overlap of bodies in the given start [m]; run() moves them apart before the simulation begins. 0: no overlap")
      .def_ro("start_moved", &RunOutcome::start_moved, "largest motion of an object when overlaps were removed from the start [m or rad]")
      .def_ro("largest_effort", &RunOutcome::largest_effort,
              "largest torque of a motor as a share of its effort limit, at most 1; NaN if `plant` was given")
      .def_prop_ro(
          "largest_press", [](const RunOutcome& r) { return r.handling.force; },
          "largest normal force of one contact pair on a free object, as a multiple of the object's weight; None: no free object, or "
          "`plant` was given")
      .def_prop_ro(
          "slip_speeds", [](const RunOutcome& r) { return r.handling.slip_speeds; },
          "for each piece, the largest excess of a free object's speed over its planned speed until the next piece began [m/s]; empty if "
          "`plant` was given")
      .def_prop_ro(
          "times",
          [](const RunOutcome& r) -> Eigen::VectorXd {
            return Eigen::Map<const Eigen::VectorXd>(r.result.times.data(), static_cast<Eigen::Index>(r.result.times.size()));
          },
          "time of each sample [s] (samples)")
      .def_prop_ro(
          "q", [](const RunOutcome& r) { return rows(r.result.q); }, "measured configurations (samples, n_q)")
      .def_prop_ro(
          "q_plan", [](const RunOutcome& r) { return rows(r.result.q_plan); }, "planned configurations (samples, n_q)")
      .def_prop_ro(
          "u", [](const RunOutcome& r) { return rows(r.result.u); }, "commands (samples, n_a) [rad or m]")
      .def_prop_ro("piece", of(&RunResult::piece), "index into `pieces` (samples); -1 before the first piece")
      .def("__repr__", [](const RunOutcome& r) {
        return fmt::format("<stiction.RunResult: {}, {:.2f} s, {} plans>", execution::to_string(r.result.end), r.result.duration_s,
                           r.result.plans.size());
      });
  const RunOptions standard;
  m.def("run", &run, "target"_a, nb::kw_only(), "goals"_a = nb::none(), "hold"_a = standard.hold, "plant"_a = nb::none(),
        "options"_a = nb::none(), "seed"_a = nb::none(), "speed"_a = 1.0, "replans"_a = standard.replans, "duration"_a = standard.duration,
        "friction_scale"_a = 1.0, "mass_scale"_a = 1.0, "pose_noise"_a = std::pair(0.0, 0.0), "pose_delay"_a = 0.0,
        "pushes"_a = nb::make_tuple(), "threads"_a = 0, "timeout_s"_a = 300.0, "plan_timeout_s"_a = standard.plan_timeout,
        "plan_processor_s"_a = nb::none(), "planning_rate"_a = standard.planning_rate, "plan_step_time_s"_a = nb::none(),
        "active_hold"_a = standard.active_hold, "join"_a = standard.join, "finger_gait"_a = standard.finger_gait,
        "touch_first"_a = nb::none(), "on_progress"_a = nb::none(), "on_sample"_a = nb::none(),
        R"(Moves the object of a task to its goal in closed loop, in MuJoCo or on your own robot (E.13)-(E.15).

The run carries a plan out at real speed and watches the object. When the object leaves its planned path, the planner makes a new plan
from the measured state. Use run() to test a task under wrong friction, mass or noise, or to control a robot.

  target: a Task, or a Plan with which the run begins.
  goals: goals that replace the goal of the task: a list, or the name of a file (.yaml) with a list. Each goal is a list of numbers as in
    Task.set_goal, or a dict as `goal` in a task file. The run brings the object to one goal after another, while the clock goes on. It
    holds each goal before it begins the next one, and a goal that is not reached ends the run. `duration` and `timeout_s` are for all
    goals together. None: the goal of the task.
  hold: time that the object has to stay within the tolerances before a goal counts as reached [s], >= 0. 0: the goal counts as soon as
    the object is seen within the tolerances, also during a push.
  plant: your own robot or simulation; docs/theory/running.md describes the interface. It is an object with two methods. read() returns a
    Measurement, or None if the robot does not answer. command(u, period) moves the commands linearly to u within period [s], returns
    when the period is over, and may return False if the command was not taken. If the clock of the plant runs by itself, give it an
    attribute real_time = True: the robot is then commanded while the planner works. An error in these methods ends the run and is raised.
    None: a simulation in MuJoCo, to which friction_scale, mass_scale, pose_noise, pose_delay and pushes apply.
  options: of the planner: PlannerOptions, or a dict with the options to change. None: the options of the target.
  seed: of the plans and of the noise. None: the seed of the options.
  speed: factor on the speed that follows from the object and the motors (E.13), > 0. A factor above 1 makes only the pushes faster.
  replans: largest number of plans after the first plan of a goal, >= 0.
  duration: largest length of the run by the clock of the plant [s], > 0.
  friction_scale, mass_scale: factors of every coefficient of friction and of the mass of every object in the simulation.
  pose_noise: standard deviations of the measured object poses: (position [m], angle [rad]).
  pose_delay: age of an object pose when the run receives it [s].
  pushes: external forces on the object, each as (begin [s], duration [s], force in W [N] (3)).
  threads: of the planner; 0: all cores. The result does not depend on this number.
  timeout_s: largest wall time of the run [s], > 0.
  plan_timeout_s: largest wall time of one plan [s], > 0.
  plan_processor_s: largest processor time of one plan, summed over all cores of the process [s], > 0. Other load on the machine does not
    shorten this budget. None: only plan_timeout_s limits a plan.
  planning_rate: processor time that the planner gets in one second of the plant's clock [s], >= 0 (E.20). The clock goes on while the
    planner works. 0: the clock stands still while the planner works.
  plan_step_time_s: time that the plant's clock is charged for each step of the planner [s], > 0, in place of the measured processor time.
    A run is then the same on every machine. None: the measured processor time.
  active_hold: while no piece of a plan is carried out, the fingers of a hand keep a free object where it is (E.21). False: the command is constant.
  join: before a search, the run tries to continue the previous plan from the measured state (E.22). It searches only if the previous
    plan does not lead to the goal.
  finger_gait: if an object would roll out of an open hand, the fingers turn it to its goal step by step; one finger at a time goes back
    to its first contact (E.23). The planner is called only if this does not reach the goal. False: the planner is always called.
  touch_first: guarded moves that the robot carries out before the run, in the same simulated world (docs/guarded_moves.md). Give a
    TouchScenario of this task, or the name or file of a scenario with the key `task`. The planner then takes the fixed bodies to be where
    the arm felt them. If target is a Plan, it is replaced by a new plan.
  on_progress: function that is called with Progress (iteration: number of plans; size: number of pieces; best: distance from the goal in
    tolerances). Ctrl-C, an error in the function or the return value False stop the run, and the robot holds its last command.
  on_sample: function that is called with a RunSample 50 times a second of the plant's clock. An error in the function stops the run.

Returns a RunResult. Its status is Solved if all goals were reached; otherwise it is MaxIterations, Cancelled or NumericalFailure, and
`end` and `message` give the reason. Raises InvalidInput.

    >>> run = st.run(st.load_task("planar_pushing"), seed=0, duration=0.5)
    >>> run.end, run.reached
    (RunEnd.TimeUp, False))");
  def_pickle<Look, RunPlan, RunGoal, RunPiece, RunOutcome>();
}

}  // namespace stiction::python
