#include <fmt/format.h>

#include "pickles.hpp"
#include "plan.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/execution/open_loop/transfer.hpp"
#include "stiction/execution/open_loop/tube.hpp"

namespace stiction::python {
namespace {

using execution::PieceError;
using execution::PieceReport;
using execution::SpeedLimits;
using execution::TransferOptions;
using execution::TransferResult;

TransferResult transfer(const Plan& given, double speed, double pause, const std::optional<SpeedLimits>& uniform,
                        std::optional<int> substeps, double rest_time, double friction_scale, double mass_scale,
                        const std::optional<Vector>& start_error, Flag velocity_reference, double hold, Flag whole, Flag alone, int threads,
                        std::optional<double> timeout_s) {
  const nb::gil_scoped_release unlocked;
  core::require_positive("speed", speed);
  planning::Plan plan = tasks::to_plan(given.model(), given.file);
  planning::Plan predicted;
  if (substeps) {
    (void)execution::predict(given.model(), plan, *substeps, predicted);
    plan.segments.resize(predicted.segments.size());  // what was predicted is run and compared
  }
  TransferOptions options;
  options.speed = speed;
  options.pause = pause;
  options.uniform = uniform;
  if (start_error) options.start_error = require_vector("start_error", *start_error, given.model().n_vu());
  options.hold = hold;
  options.whole = whole;
  options.alone = alone;
  options.threads = threads;
  simulation::PlantOptions plant_options;
  plant_options.rest_time = rest_time;
  plant_options.velocity_reference = velocity_reference;
  plant_options.effort_limits = given.file.step.effort_limits;
  plant_options.contact.friction_scale = friction_scale;
  plant_options.mass_scale = mass_scale;
  core::RunControl control;
  if (timeout_s) control.deadline = deadline_in(*timeout_s);
  TransferResult out;
  (void)execution::transfer(simulation::Plant::make(given.task.model, plant_options), plan, options, control, out,
                            substeps ? &predicted : nullptr);
  return out;
}

using execution::ErrorSets;
using execution::TubeFactors;
using execution::TubeOptions;
using execution::TubeRest;
using execution::TubeResult;
using execution::WorldError;

WorldError draw_world(const Plan& given, const ErrorSets& errors, std::uint64_t seed, std::uint64_t index) {
  const planning::Plan plan = tasks::to_plan(given.model(), given.file);
  return execution::draw_world(given.model(), execution::start_of(given.model(), plan), errors, seed, index);
}

TubeResult calc_tube(const Plan& given, const ErrorSets& errors, const std::pair<double, double>& factors, int scenarios,
                     std::uint64_t seed, int threads, std::optional<double> timeout_s) {
  const nb::gil_scoped_release unlocked;
  TubeOptions options;
  options.errors = errors;
  options.factors = {factors.first, factors.second};
  options.scenarios = scenarios;
  options.seed = seed;
  options.threads = threads;
  core::RunControl control;
  if (timeout_s) control.deadline = deadline_in(*timeout_s);
  TubeResult out;
  (void)execution::calc_tube(given.task.model, tasks::to_plan(given.model(), given.file), options, control, out);
  return out;
}

void bind_error_sets(nb::module_& m) {
  const ErrorSets sets;
  nb::class_<ErrorSets>(m, "ErrorSets", "Sets in which the errors of a model lie (docs/theory/tube.md).")
      .def(
          "__init__",
          [](ErrorSets* out, double position, double angle, double friction, double mass, double contact) {
            new (out) ErrorSets{.position = position, .angle = angle, .friction = friction, .mass = mass, .contact = contact};
            out->validate();
          },
          nb::kw_only(), "position"_a = sets.position, "angle"_a = sets.angle, "friction"_a = sets.friction, "mass"_a = sets.mass,
          "contact"_a = sets.contact,
          "position [m] and angle [rad]: of objects at the start, >= 0. friction, mass: shares by which every coefficient of friction and "
          "the mass of every object are off at most, in [0, 1). contact: of the gap of a contact, in lengths of the object of the goal, >= "
          "0. Raises InvalidInput.")
      .def_ro("position", &ErrorSets::position, "[m]")
      .def_ro("angle", &ErrorSets::angle, "[rad]")
      .def_ro("friction", &ErrorSets::friction)
      .def_ro("mass", &ErrorSets::mass)
      .def_ro("contact", &ErrorSets::contact, "in lengths of the object");
  nb::class_<WorldError>(m, "WorldError", "One world in sets of errors.")
      .def_ro("start", &WorldError::start, "of the objects in their tangent (n_vu) [m, rad]")
      .def_ro("friction", &WorldError::friction, "factor of every coefficient of friction")
      .def_ro("mass", &WorldError::mass, "factor of the mass of every object");
  m.def("draw_world", &draw_world, "plan"_a, "errors"_a = sets, nb::kw_only(), "seed"_a = 0, "index"_a = 0,
        R"(A random world in the sets around the start of a plan: another one for each index, the same ones for a seed.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> world = st.draw_world(plan, st.ErrorSets(friction=0.0), index=3)
    >>> world.friction, len(world.start), bool(0.7 <= world.mass <= 1.3)
    (1.0, 3, True))");
}

void bind_tube(nb::module_& m) {
  bind_error_sets(m);
  nb::class_<TubeRest>(m, "TubeRest", "Where the object is at the end of a push or a regrasp.")
      .def_ro("kind", &TubeRest::kind, "Contact or Regrasp")
      .def_ro("last_segment", &TubeRest::last_segment, "of the plan, which ends here")
      .def_ro("centre", &TubeRest::centre, "pose that the bound is around")
      .def_ro("offset", &TubeRest::offset, "of the centre from where the plan has the object")
      .def_ro("position", &TubeRest::position, "the object is within this of the centre [m]")
      .def_ro("angle", &TubeRest::angle, "and turned from it by this at most [rad]; infinite where a scenario was lost")
      .def_ro("scenarios", &TubeRest::scenarios, "poses in the bundle, that of the known world first");
  nb::class_<TubeResult>(m, "TubeResult", "A bound of where the object of a plan is at every rest.")
      .def_ro("status", &TubeResult::status)
      .def_ro("rests", &TubeResult::rests, "ends of pushes and regrasps, in their order")
      .def_ro("goal", &TubeResult::goal, "bound of the distance from the goal at the end")
      .def_ro("calibrated", &TubeResult::calibrated,
              "runs in the simulation stay inside as often as the factors promise: in planar scenes alone")
      .def_ro("inside", &TubeResult::inside, "the bound is within the tolerances of the goal, and calibrated")
      .def_ro("lost", &TubeResult::lost, "scenarios in which a step had no solution")
      .def_ro("steps", &TubeResult::steps)
      .def_ro("wall_s", &TubeResult::wall_s);
  const TubeOptions standard;
  m.def("calc_tube", &calc_tube, "plan"_a, "errors"_a = standard.errors, nb::kw_only(),
        "factors"_a = std::pair(standard.factors.position, standard.factors.angle), "scenarios"_a = standard.scenarios,
        "seed"_a = standard.seed, "threads"_a = standard.threads, "timeout_s"_a = nb::none(),
        R"(A bound of where the object of a plan is at every rest when the plan is carried out without feedback (docs/theory/tube.md).

  errors: sets that contain what differs from the model.
  factors: by which the tube is wider than the bundle in position and angle, > 0; the default was calibrated on runs in MuJoCo.
  scenarios: worlds that are drawn from the sets, beside the known one, >= 1. seed: of these.
  threads: 0 for all cores; the result does not depend on it. timeout_s: [s] > 0; None: as long as it takes.

status: Solved; MaxIterations (time used up; no rests). Raises InvalidInput.

    >>> plan = st.refine(st.plan(st.load_task("iiwa_bimanual_planar"), seed=0).plan).plan
    >>> tube = st.calc_tube(plan)
    >>> tube.status, tube.inside, len(tube.rests[0].scenarios)
    (Status.Solved, True, 17))");
}

void bind_piece(nb::module_& m) {
  nb::class_<PieceError>(m, "PieceError", "Planned against simulated pose of the object over one piece (3.10)-(3.12).")
      .def_ro("mean_position", &PieceError::mean_position, "[m]")
      .def_ro("mean_angle", &PieceError::mean_angle, "[rad]")
      .def_ro("start_position", &PieceError::start_position, "[m]")
      .def_ro("start_angle", &PieceError::start_angle, "[rad]")
      .def_ro("end_position", &PieceError::end_position, "[m]")
      .def_ro("end_angle", &PieceError::end_angle, "[rad]")
      .def_ro("length_position", &PieceError::length_position, "of the planned path [m]")
      .def_ro("length_angle", &PieceError::length_angle, "of the planned path [rad]")
      .def_prop_ro("normalised_position", &PieceError::normalised_position,
                   "None where the plan moves the object by less than a thousandth of its length")
      .def_prop_ro("normalised_angle", &PieceError::normalised_angle);
  nb::class_<PieceReport>(m, "PieceReport", "A push or a regrasp of a run beside its plan.")
      .def_ro("kind", &PieceReport::kind, "Contact or Regrasp")
      .def_ro("first_segment", &PieceReport::first_segment)
      .def_ro("last_segment", &PieceReport::last_segment)
      .def_ro("begin_s", &PieceReport::begin_s)
      .def_ro("end_s", &PieceReport::end_s)
      .def_ro("in_plan", &PieceReport::in_plan, "with what earlier pieces left behind; None where the whole run ended before")
      .def_ro("alone", &PieceReport::alone, "started from the planned state; None for regrasps");
}

}  // namespace

void bind_execution(nb::module_& m) {
  bind_piece(m);
  nb::class_<TransferResult>(m, "TransferResult", "A plan run open loop, beside what it predicts.")
      .def_ro("status", &TransferResult::status)
      .def_ro("message", &TransferResult::message)
      .def_ro("pieces", &TransferResult::pieces)
      .def_ro("error", &TransferResult::error, "of the object at the end")
      .def_ro("reached", &TransferResult::reached)
      .def_ro("dropped", &TransferResult::dropped, "index of the first object that fell, or None")
      .def_ro("dropped_s", &TransferResult::dropped_s, "and when [s]")
      .def_ro("max_depth", &TransferResult::max_depth, "deepest penetration [m]")
      .def_ro("duration_s", &TransferResult::duration_s, "simulated [s]")
      .def_prop_ro(
          "times",
          [](const TransferResult& r) -> Eigen::VectorXd {
            return Eigen::Map<const Eigen::VectorXd>(r.times.data(), static_cast<Eigen::Index>(r.times.size()));
          },
          "[s] (samples)")
      .def_prop_ro(
          "q", [](const TransferResult& r) { return rows(r.q); }, "simulated (samples, n_q)")
      .def_prop_ro(
          "q_plan", [](const TransferResult& r) { return rows(r.q_plan); }, "planned (samples, n_q)")
      .def_ro("piece", &TransferResult::piece, "index into pieces (samples)")
      .def_ro("wall_s", &TransferResult::wall_s);
  const SpeedLimits limits;
  nb::class_<SpeedLimits>(m, "SpeedLimits", "Speeds of commands that are the same for any object and robot (E.1), (E.8), (E.9).")
      .def(
          "__init__",
          [](SpeedLimits* out, double revolute, double prismatic, double regrasp_factor, double load_time, double pause) {
            new (out) SpeedLimits{
                .revolute = revolute, .prismatic = prismatic, .regrasp_factor = regrasp_factor, .load_time = load_time, .pause = pause};
            out->validate();
          },
          nb::kw_only(), "revolute"_a = limits.revolute, "prismatic"_a = limits.prismatic, "regrasp_factor"_a = limits.regrasp_factor,
          "load_time"_a = limits.load_time, "pause"_a = limits.pause,
          "revolute [rad/s] and prismatic [m/s] while pushing, regrasps regrasp_factor times as fast, all > 0; springs take up the weight "
          "of the "
          "lightest object in load_time [s] and commands rest for pause [s] between pieces, both >= 0. Raises InvalidInput.")
      .def_ro("revolute", &SpeedLimits::revolute, "[rad/s]")
      .def_ro("prismatic", &SpeedLimits::prismatic, "[m/s]")
      .def_ro("regrasp_factor", &SpeedLimits::regrasp_factor)
      .def_ro("load_time", &SpeedLimits::load_time, "[s]")
      .def_ro("pause", &SpeedLimits::pause, "[s]");
  m.def("transfer", &transfer, "plan"_a, nb::kw_only(), "speed"_a = TransferOptions{}.speed, "pause"_a = 0.0, "uniform"_a = nb::none(),
        "substeps"_a = nb::none(), "rest_time"_a = execution::kRestTime, "friction_scale"_a = 1.0, "mass_scale"_a = 1.0,
        "start_error"_a = nb::none(), "velocity_reference"_a = true, "hold"_a = TransferOptions{}.hold, "whole"_a = true, "alone"_a = true,
        "threads"_a = 0, "timeout_s"_a = nb::none(),
        R"(Runs a plan open loop in the second-order simulation and compares it with what the plan predicts (3.10)-(3.12).

  speed: times the full timing that follows from the object and the motors (E.13), > 0; above 1 only pushes are faster. Without feedback most plans hold at
    the default of 0.1, and few at 1.
  pause: commands rest this long between pieces [s], >= 0.
  uniform: in place of speed and pause, limits that are the same for any object and robot, and commands as the plan has them (E.1).
  substeps: every contact edge is predicted anew in so many steps first; None: as the plan does.
  rest_time: in which objects on joints come to rest [s].
  friction_scale, mass_scale: factors of every coefficient of friction, >= 0, and of the mass of every object, > 0.
  start_error: by what the objects are off their start in their tangent (n_vu) [m, rad]; overlaps are moved apart. None: not at all.
  velocity_reference: damping of the joint springs acts on the difference to the commanded velocity; else on the velocity, so that
    joints lag behind their commands, as in the thesis.
  hold: the last command is held so long before the goal is judged [s].
  whole: run the whole plan. alone: run every push by itself from its planned start.
  threads: for those; 0 for all cores; the result does not depend on it.
  timeout_s: [s] > 0; None: as long as it takes.

status: Solved: run to the end, whatever came out; MaxIterations (time used up); NumericalFailure (`message`). Raises InvalidInput.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> run = st.transfer(plan, speed=20.0, pause=0.2, hold=0.2, alone=False)
    >>> run.status, run.q.shape == (len(run.times), 5)
    (Status.Solved, True))");
  bind_tube(m);
  def_pickle<PieceError, PieceReport, TransferResult, SpeedLimits, ErrorSets, WorldError, TubeRest, TubeResult>();
}

}  // namespace stiction::python
