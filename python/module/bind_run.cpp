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
  std::optional<GuardedResult> touch;            ///< guarded moves before it
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
  nb::enum_<RunEnd>(m, "RunEnd", "Why a run ended.")
      .value("Reached", RunEnd::Reached, "the goal held")
      .value("Dropped", RunEnd::Dropped, "an object fell")
      .value("NoPlan", RunEnd::NoPlan, "the planner found none, or refused the start")
      .value("Replans", RunEnd::Replans, "used up")
      .value("TimeUp", RunEnd::TimeUp, "`duration` is over")
      .value("Deadline", RunEnd::Deadline, "`timeout_s` is over")
      .value("Cancelled", RunEnd::Cancelled)
      .value("Silent", RunEnd::Silent, "the plant does not answer")
      .value("Unfelt", RunEnd::Unfelt, "guarded moves before the run did not end as they should");
  nb::enum_<RunState>(m, "RunState", "What a run does at a moment.")
      .value("Hold", RunState::Hold, "commands rest: something settles, or the goal has to hold")
      .value("Push", RunState::Push, "the robot pushes")
      .value("Regrasp", RunState::Regrasp, "the robot moves to new contacts")
      .value("Replan", RunState::Replan, "commands rest while the planner works");
  nb::class_<Look>(m, "RunSample", "What is seen and decided at one look of a run.")
      .def_ro("time", &Look::time, "since the start of the run [s]")
      .def_ro("state", &Look::state)
      .def_ro("q", &Look::q, "measured (n_q)")
      .def_ro("q_plan", &Look::q_plan, "as planned for this moment; where nothing is planned as measured (n_q)")
      .def_ro("u", &Look::u, "commands (n_a) [rad or m]")
      .def_ro("piece", &Look::piece, "index into RunResult.pieces; -1 before the first")
      .def_ro("plans", &Look::plans, "so far")
      .def_ro("goal_share", &Look::goal_share, "how far the object is from the goal, in its tolerances")
      .def_ro("goal", &Look::goal, "which one of goals in a row")
      .def_ro("torque", &Look::torque,
              "of the motors, of each the largest since the sample before (n_a) [N m or N]; empty of a plant of one's own")
      .def_ro("forces", &Look::forces, "by pair; empty of a plant of one's own");
  nb::class_<RunPlan>(m, "RunPlan", "One call of the planner.")
      .def_ro("time", &RunPlan::time, "of the run, when it was asked [s]")
      .def_ro("wall_s", &RunPlan::wall_s, "that it took")
      .def_ro("processor_s", &RunPlan::processor_s, "... of all cores of the process [s]")
      .def_ro("clock_s", &RunPlan::clock_s, "... and of the clock of the plant [s]")
      .def_ro("status", &RunPlan::status)
      .def_ro("cause", &RunPlan::cause, "why it was asked")
      .def_ro("joined", &RunPlan::joined, "the plan before was gone on with, and nothing was searched")
      .def_ro("reason", &RunPlan::reason, "what the planner said, where it found nothing");
  nb::class_<RunGoal>(m, "RunGoal", "One goal of a run.")
      .def_ro("reached", &RunGoal::reached)
      .def_ro("begin_s", &RunGoal::begin_s, "since the start of the run, when it was the next one to be reached")
      .def_ro("end_s", &RunGoal::end_s, "... when it had been held for as long as asked, or the run ended")
      .def_ro("replans", &RunGoal::replans, "plans after the first one for it")
      .def_ro("error", &RunGoal::error, "at its end, as measured");
  nb::class_<RunPiece>(m, "RunPiece", "What was carried out of a piece of a plan.")
      .def_ro("kind", &RunPiece::kind, "Contact or Regrasp")
      .def_ro("plan", &RunPiece::plan, "index into RunResult.plans; -1: the given one, or none was needed yet")
      .def_ro("begin_s", &RunPiece::begin_s)
      .def_ro("end_s", &RunPiece::end_s)
      .def_ro("off", &RunPiece::off, "how far the object was off its path at the end, in tolerances of the goal")
      .def_ro("given_up", &RunPiece::given_up, "it was too far off");
}

}  // namespace

void bind_run(nb::module_& m) {
  bind_parts(m);
  bind_plants(m);
  const auto of = [](auto member) { return [member](const RunOutcome& r) { return r.result.*member; }; };
  nb::class_<RunOutcome>(m, "RunResult", "What came of bringing an object to its goal in closed loop.")
      .def_prop_ro("status", of(&RunResult::status), "Solved: reached")
      .def_prop_ro("end", of(&RunResult::end), "why the run ended")
      .def_prop_ro("message", of(&RunResult::message), "the same in words, where the goal was not reached")
      .def_prop_ro(
          "reached", [](const RunOutcome& r) { return r.result.reached(); }, "all goals")
      .def_prop_ro("goals", of(&RunResult::goals), "those that were begun, in a row")
      .def_prop_ro("goals_reached", [](const RunOutcome& r) { return r.result.goals_reached(); })
      .def_prop_ro("error", of(&RunResult::error), "of the object at the end, as measured")
      .def_ro("true_error", &RunOutcome::true_error, "... and as it is; of a plant of one's own as measured")
      .def_prop_ro(
          "touch", [](const RunOutcome& r) { return r.touch ? &*r.touch : nullptr; }, nb::rv_policy::reference_internal,
          "what became of the moves of touch_first; None: there were none")
      .def_prop_ro("duration_s", of(&RunResult::duration_s), "by the clock of the plant [s]")
      .def_prop_ro("planning_s", of(&RunResult::planning_s), "wall time of all plans")
      .def_prop_ro("wall_s", of(&RunResult::wall_s))
      .def_prop_ro("plans", of(&RunResult::plans))
      .def_prop_ro("pieces", of(&RunResult::pieces))
      .def_prop_ro("replans", of(&RunResult::replans), "plans that something on the way called for")
      .def_prop_ro("pushes", [](const RunOutcome& r) { return r.result.count(planning::SegmentKind::Contact); })
      .def_prop_ro("regrasps", [](const RunOutcome& r) { return r.result.count(planning::SegmentKind::Regrasp); })
      .def_prop_ro("dropped", of(&RunResult::dropped), "index of the object that fell, or None")
      .def_ro("max_depth", &RunOutcome::max_depth, "deepest penetration [m]; NaN of a plant of one's own")
      .def_ro("start_overlap", &RunOutcome::start_overlap,
              "deepest overlap of a start that was moved apart before the plant began [m]; 0: it is as it was given")
      .def_ro("start_moved", &RunOutcome::start_moved, "by how much an object was moved then, at most [m or rad]")
      .def_ro("largest_effort", &RunOutcome::largest_effort, "share of a motor's effort, at most 1; NaN of a plant of one's own")
      .def_prop_ro(
          "largest_press", [](const RunOutcome& r) { return r.handling.force; },
          "largest normal force of one pair on a free object, as a multiple of its weight; None: no such object, or a plant of one's own")
      .def_prop_ro(
          "slip_speeds", [](const RunOutcome& r) { return r.handling.slip_speeds; },
          "per piece, how much faster than planned a free object was until the next piece began [m/s]; empty for a plant of one's own")
      .def_prop_ro(
          "times",
          [](const RunOutcome& r) -> Eigen::VectorXd {
            return Eigen::Map<const Eigen::VectorXd>(r.result.times.data(), static_cast<Eigen::Index>(r.result.times.size()));
          },
          "[s] (looks)")
      .def_prop_ro(
          "q", [](const RunOutcome& r) { return rows(r.result.q); }, "measured (looks, n_q)")
      .def_prop_ro(
          "q_plan", [](const RunOutcome& r) { return rows(r.result.q_plan); }, "planned (looks, n_q)")
      .def_prop_ro(
          "u", [](const RunOutcome& r) { return rows(r.result.u); }, "commands (looks, n_a) [rad or m]")
      .def_prop_ro("piece", of(&RunResult::piece), "index into pieces (looks); -1 before the first")
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
        R"(Brings the object of a task to its goal in MuJoCo: carries plans out at real speed and plans anew where they fail (E.13)-(E.15).

  target: a Task, or a Plan to begin with.
  goals: in place of that of the task, reached one after another while the clock goes on: a list, or the name of a file with one (.yaml).
    Each is numbers as of Task.set_goal, or a dict as `goal` of a task. Each is held before the next one begins, and one that is not
    reached ends the run; `duration` and `timeout_s` are those of all. None: that of the task.
  hold: a goal counts once the object was within its tolerances for so long [s], >= 0; 0: as soon as it is seen there, on its way as well.
  plant: what carries commands out: an object with read(), which gives a Measurement or None where the robot does not answer, and
    command(u, period), which moves the commands straight to u within period [s], returns when that is over, and may give False where
    they are not taken. A plant whose clock goes on by itself has an attribute real_time that is True: it is commanded while the planner works.
    An error in them ends the run and is raised. None: MuJoCo, to which the factors, noise and pushes apply.
  options: of the planner: PlannerOptions, or a dict of those that differ from the target's; None: the target's.
  seed: of the plans and of the noise; None: that of the options.
  speed: times that which follows from object and motors, > 0; above 1 of pushes alone.
  replans: after the first plan of a goal, at most, >= 0. duration: by the clock of the plant, at most [s], > 0.
  friction_scale, mass_scale: factors of every coefficient of friction and of the mass of every object in the simulation.
  pose_noise: standard deviations of measured object poses [m], [rad]. pose_delay: they are seen so late [s].
  pushes: forces on the object from outside: (begin [s], duration [s], force in W [N] (3)).
  threads: of the planner, 0 for all cores; the result does not depend on it. timeout_s: of the run [s], > 0.
  plan_timeout_s: of one plan [s], > 0. plan_processor_s: ... or this much time of all cores of the process [s], > 0, which other work
    on the machine does not shorten; None: plan_timeout_s alone.
  planning_rate: seconds of one core that the planner works within a second of the plant's clock, which goes on meanwhile, >= 0; 0: it
    stands still. plan_step_time_s: each step that the planner computes is charged like this [s], > 0, so that a run is the same on every
    machine; None: the processor time that it took.
  active_hold: the fingers of a hand keep a free object where it is while nothing is carried out (E.21); False: commands rest.
  join: before the planner searches, the plan before is gone on with, where that leads to the goal.
  finger_gait: an object that would roll out of an open hand is turned to its goal by the fingers, one of which at a time goes back (E.23).
  touch_first: guarded moves that are carried out first, in the world in which the run goes on (docs/guarded_moves.md): a TouchScenario of
    this task, or the name or file of one with the key `task`. Fixed bodies are then planned for where the arm felt them, also if a
    Plan was given.
  on_progress: called with Progress (iteration: plans, size: pieces, best: tolerances from the goal); Ctrl-C and an error in it stop the
    run, and the robot holds. on_sample: called with RunSample at every look, 50 a second of the plant's clock; an error in it stops the run as well.

status: Solved: reached; MaxIterations, Cancelled or NumericalFailure: `end` and `message` say what. Raises InvalidInput.

    >>> run = st.run(st.load_task("planar_pushing"), seed=0, duration=0.5)
    >>> run.end, run.reached
    (RunEnd.TimeUp, False))");
  def_pickle<Look, RunPlan, RunGoal, RunPiece, RunOutcome>();
}

}  // namespace stiction::python
