#include <fmt/format.h>

#include "pickles.hpp"
#include "plan.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/execution/open_loop/transfer.hpp"
#include "stiction/execution/open_loop/tube.hpp"
#include "watcher.hpp"

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
  Interrupt interrupt;
  TransferResult out;
  (void)execution::transfer(simulation::Plant::make(given.task.model, plant_options), plan, options, interrupt.control(timeout_s), out,
                            substeps ? &predicted : nullptr);
  interrupt.rethrow();
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
  Interrupt interrupt;
  TubeResult out;
  (void)execution::calc_tube(given.task.model, tasks::to_plan(given.model(), given.file), options, interrupt.control(timeout_s), out);
  interrupt.rethrow();
  return out;
}

void bind_error_sets(nb::module_& m) {
  const ErrorSets sets;
  nb::class_<ErrorSets>(m, "ErrorSets",
                        "Bounds on the errors of a model: start pose, friction, mass and contact geometry (docs/theory/tube.md).")
      .def(
          "__init__",
          [](ErrorSets* out, double position, double angle, double friction, double mass, double contact) {
            new (out) ErrorSets{.position = position, .angle = angle, .friction = friction, .mass = mass, .contact = contact};
            out->validate();
          },
          nb::kw_only(), "position"_a = sets.position, "angle"_a = sets.angle, "friction"_a = sets.friction, "mass"_a = sets.mass,
          "contact"_a = sets.contact,
          R"(Bounds on the errors of a model.

  position, angle: largest error of an object's pose at the start [m], [rad], >= 0.
  friction, mass: largest relative error of the coefficients of friction and of the masses of the objects, in [0, 1).
  contact: largest error of the gap of a contact, in lengths of the object of the goal, >= 0.

Raises InvalidInput.)")
      .def_ro("position", &ErrorSets::position, "bound on the position error of objects at the start [m]")
      .def_ro("angle", &ErrorSets::angle, "bound on the angle error of objects at the start [rad]")
      .def_ro("friction", &ErrorSets::friction, "bound on the relative error of friction")
      .def_ro("mass", &ErrorSets::mass, "bound on the relative error of masses")
      .def_ro("contact", &ErrorSets::contact, "bound on the error of a gap, in lengths of the object");
  nb::class_<WorldError>(m, "WorldError", "One sample of the model errors, as draw_world() returns it.")
      .def_ro("start", &WorldError::start, "error of the objects' start in tangent coordinates (n_vu) [m, rad]")
      .def_ro("friction", &WorldError::friction, "factor of every coefficient of friction")
      .def_ro("mass", &WorldError::mass, "factor of the mass of every object");
  m.def("draw_world", &draw_world, "plan"_a, "errors"_a = sets, nb::kw_only(), "seed"_a = 0, "index"_a = 0,
        R"(Draws a random sample of the model errors within their bounds, for the start of a plan.

  plan: Plan whose start and model are used.
  errors: ErrorSets with the bounds.
  seed, index: each index gives another sample; the same seed and index give the same sample.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> world = st.draw_world(plan, st.ErrorSets(friction=0.0), index=3)
    >>> world.friction, len(world.start), bool(0.7 <= world.mass <= 1.3)
    (1.0, 3, True))");
}

void bind_tube(nb::module_& m) {
  bind_error_sets(m);
  nb::class_<TubeRest>(m, "TubeRest", "Bound on the object's pose at the end of a push or a regrasp.")
      .def_ro("kind", &TubeRest::kind, "Contact or Regrasp")
      .def_ro("last_segment", &TubeRest::last_segment, "index of the plan's last segment before this rest")
      .def_ro("centre", &TubeRest::centre, "centre of the bound, a pose in W")
      .def_ro("offset", &TubeRest::offset, "distance of the centre from the planned pose")
      .def_ro("position", &TubeRest::position, "largest distance of the object from the centre [m]")
      .def_ro("angle", &TubeRest::angle, "largest angle of the object from the centre [rad]; infinite if a scenario failed")
      .def_ro("scenarios", &TubeRest::scenarios, "poses of the object in the scenarios, the nominal one first");
  nb::class_<TubeResult>(m, "TubeResult", "Result of calc_tube(): bounds on the object's pose along a plan.")
      .def_ro("status", &TubeResult::status)
      .def_ro("rests", &TubeResult::rests, "bounds at the ends of pushes and regrasps, in order")
      .def_ro("goal", &TubeResult::goal, "bound on the distance from the goal at the end")
      .def_ro("calibrated", &TubeResult::calibrated,
              "True: simulated runs stay inside the bound as often as the calibration promises; only in planar scenes")
      .def_ro("inside", &TubeResult::inside, "True: the bound is calibrated and lies within the tolerances of the goal")
      .def_ro("lost", &TubeResult::lost, "number of scenarios in which a step had no solution")
      .def_ro("steps", &TubeResult::steps, "number of steps that were simulated")
      .def_ro("wall_s", &TubeResult::wall_s, "wall time [s]");
  const TubeOptions standard;
  m.def(
      "calc_tube", &calc_tube, "plan"_a, "errors"_a = standard.errors, nb::kw_only(),
      "factors"_a = std::pair(standard.factors.position, standard.factors.angle), "scenarios"_a = standard.scenarios,
      "seed"_a = standard.seed, "threads"_a = standard.threads, "timeout_s"_a = nb::none(),
      R"(Bounds the pose of the object after every push and regrasp, if a plan is executed without feedback under model errors (docs/theory/tube.md).

The plan is simulated in several scenarios, each with random errors within the bounds `errors`. The bound encloses all scenarios.

  errors: ErrorSets with the bounds on the model errors.
  factors: factors (position, angle) by which the bound is larger than the spread of the scenarios, > 0. The default was calibrated on runs
    in MuJoCo.
  scenarios: number of random scenarios besides the nominal one, >= 1.
  seed: of the scenarios.
  threads: 0: all cores. The result does not depend on this number.
  timeout_s: largest wall time [s], > 0. None: no limit.

Returns a TubeResult. Its status is Solved, or MaxIterations: the time was used up, and there are no rests. Raises InvalidInput.

    >>> plan = st.refine(st.plan(st.load_task("iiwa_bimanual_planar"), seed=0, options={"margins": True}).plan).plan
    >>> tube = st.calc_tube(plan)
    >>> tube.status, tube.inside, len(tube.rests[0].scenarios)
    (Status.Solved, True, 17))");
}

void bind_piece(nb::module_& m) {
  nb::class_<PieceError>(m, "PieceError", "Difference of the planned and the simulated object pose over one push or regrasp (3.10)-(3.12).")
      .def_ro("mean_position", &PieceError::mean_position, "mean position error over time (3.10) [m]")
      .def_ro("mean_angle", &PieceError::mean_angle, "mean angle error over time (3.10) [rad]")
      .def_ro("start_position", &PieceError::start_position, "position error at the start [m]")
      .def_ro("start_angle", &PieceError::start_angle, "angle error at the start [rad]")
      .def_ro("end_position", &PieceError::end_position, "position error at the end [m]")
      .def_ro("end_angle", &PieceError::end_angle, "angle error at the end [rad]")
      .def_ro("length_position", &PieceError::length_position, "length of the object's planned path (3.12) [m]")
      .def_ro("length_angle", &PieceError::length_angle, "rotation along the object's planned path (3.12) [rad]")
      .def_prop_ro(
          "normalised_position", &PieceError::normalised_position,
          "mean position error divided by the path length (3.11); None: the plan moves the object by less than a thousandth of its length")
      .def_prop_ro("normalised_angle", &PieceError::normalised_angle,
                   "mean angle error divided by the planned rotation (3.11); None: the plan does not turn the object");
  nb::class_<PieceReport>(m, "PieceReport", "Errors of one push or regrasp in the simulation.")
      .def_ro("kind", &PieceReport::kind, "Contact or Regrasp")
      .def_ro("first_segment", &PieceReport::first_segment, "index of its first segment in the plan")
      .def_ro("last_segment", &PieceReport::last_segment, "index of its last segment in the plan")
      .def_ro("begin_s", &PieceReport::begin_s, "simulated time of its start [s]")
      .def_ro("end_s", &PieceReport::end_s, "simulated time of its end [s]")
      .def_ro("in_plan", &PieceReport::in_plan,
              "errors in the run of the whole plan, errors of earlier pieces included; None: that run ended earlier")
      .def_ro("alone", &PieceReport::alone, "errors in a run that starts from the planned state; None for regrasps");
}

}  // namespace

void bind_execution(nb::module_& m) {
  bind_piece(m);
  nb::class_<TransferResult>(m, "TransferResult", "Result of transfer(): a plan executed without feedback, compared with its prediction.")
      .def_ro("status", &TransferResult::status)
      .def_ro("message", &TransferResult::message, "reason of a numerical failure")
      .def_ro("pieces", &TransferResult::pieces, "errors of each push and regrasp")
      .def_ro("error", &TransferResult::error, "distance of the object from the goal at the end")
      .def_ro("reached", &TransferResult::reached, "True: the whole plan was run, and the object is within the tolerances of the goal")
      .def_ro("dropped", &TransferResult::dropped, "index of the first object that fell, or None")
      .def_ro("dropped_s", &TransferResult::dropped_s, "simulated time at which the object fell [s]")
      .def_ro("max_depth", &TransferResult::max_depth, "deepest penetration [m]")
      .def_ro("duration_s", &TransferResult::duration_s, "simulated duration of the run [s]")
      .def_prop_ro(
          "times",
          [](const TransferResult& r) -> Eigen::VectorXd {
            return Eigen::Map<const Eigen::VectorXd>(r.times.data(), static_cast<Eigen::Index>(r.times.size()));
          },
          "times of the samples [s] (samples)")
      .def_prop_ro(
          "q", [](const TransferResult& r) { return rows(r.q); }, "simulated configurations (samples, n_q)")
      .def_prop_ro(
          "q_plan", [](const TransferResult& r) { return rows(r.q_plan); }, "planned configurations (samples, n_q)")
      .def_ro("piece", &TransferResult::piece, "index into `pieces` (samples)")
      .def_ro("wall_s", &TransferResult::wall_s, "wall time [s]");
  const SpeedLimits limits;
  nb::class_<SpeedLimits>(m, "SpeedLimits",
                          "Fixed speed limits of commands, which do not depend on the object or the robot (E.1), (E.8), (E.9).")
      .def(
          "__init__",
          [](SpeedLimits* out, double revolute, double prismatic, double regrasp_factor, double load_time, double pause) {
            new (out) SpeedLimits{
                .revolute = revolute, .prismatic = prismatic, .regrasp_factor = regrasp_factor, .load_time = load_time, .pause = pause};
            out->validate();
          },
          nb::kw_only(), "revolute"_a = limits.revolute, "prismatic"_a = limits.prismatic, "regrasp_factor"_a = limits.regrasp_factor,
          "load_time"_a = limits.load_time, "pause"_a = limits.pause,
          R"(Fixed speed limits.

  revolute, prismatic: largest speed of a command during pushes [rad/s], [m/s], > 0.
  regrasp_factor: regrasps are this many times as fast, > 0.
  load_time: time in which joint springs take up the weight of the lightest object [s], >= 0.
  pause: time for which the command is constant between pushes and regrasps [s], >= 0.

Raises InvalidInput.)")
      .def_ro("revolute", &SpeedLimits::revolute, "largest speed of revolute joints in pushes [rad/s]")
      .def_ro("prismatic", &SpeedLimits::prismatic, "largest speed of prismatic joints in pushes [m/s]")
      .def_ro("regrasp_factor", &SpeedLimits::regrasp_factor, "factor on the speeds in regrasps")
      .def_ro("load_time", &SpeedLimits::load_time, "time in which springs take up the weight of the lightest object [s]")
      .def_ro("pause", &SpeedLimits::pause, "time of constant commands between pushes and regrasps [s]");
  m.def("transfer", &transfer, "plan"_a, nb::kw_only(), "speed"_a = TransferOptions{}.speed, "pause"_a = 0.0, "uniform"_a = nb::none(),
        "substeps"_a = nb::none(), "rest_time"_a = execution::kRestTime, "friction_scale"_a = 1.0, "mass_scale"_a = 1.0,
        "start_error"_a = nb::none(), "velocity_reference"_a = true, "hold"_a = TransferOptions{}.hold, "whole"_a = true, "alone"_a = true,
        "threads"_a = 0, "timeout_s"_a = nb::none(),
        R"(Executes a plan without feedback in the second-order simulation and compares the motion with the plan (3.10)-(3.12).

  plan: Plan.
  speed: factor on the full speed that follows from the object and the motors (E.13), > 0. A factor above 1 makes only pushes faster.
    Without feedback most plans succeed at the default of 0.1, and few succeed at 1.
  pause: time for which the command is constant between pushes and regrasps [s], >= 0.
  uniform: SpeedLimits that replace speed and pause; the commands are then those of the plan, without lead for damping (E.1). None: not used.
  substeps: number of steps in which every contact edge of the plan is predicted again before the comparison. None: the prediction of the
    plan.
  rest_time: time in which objects on joints come to rest [s].
  friction_scale, mass_scale: factors of every coefficient of friction, >= 0, and of the mass of every object, > 0.
  start_error: displacement of the objects from their start in tangent coordinates (n_vu) [m, rad]. Overlaps that result are removed. None:
    no displacement.
  velocity_reference: True: damping of the joint springs acts on the difference of commanded and actual velocity. False: it acts on the
    actual velocity, so that joints lag behind their commands, as in the thesis.
  hold: time for which the last command is held before the goal is judged [s].
  whole: True: run the whole plan.
  alone: True: also run every push by itself from its planned start.
  threads: for the runs of single pushes; 0: all cores. The result does not depend on this number.
  timeout_s: largest wall time [s], > 0. None: no limit.

Returns a TransferResult. Its status is Solved if the run came to its end, whether or not the goal was reached; MaxIterations: the time was
used up; or NumericalFailure: `message` gives the reason. Raises InvalidInput.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> run = st.transfer(plan, speed=20.0, pause=0.2, hold=0.2, alone=False)
    >>> run.status, run.q.shape == (len(run.times), 5)
    (Status.Solved, True))");
  bind_tube(m);
  def_pickle<PieceError, PieceReport, TransferResult, SpeedLimits, ErrorSets, WorldError, TubeRest, TubeResult>();
}

}  // namespace stiction::python
