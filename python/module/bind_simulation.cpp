#include <fmt/format.h>

#include "bindings.hpp"
#include "pickles.hpp"
#include "stiction/simulation/simulation.hpp"

namespace stiction::python {
namespace {

using simulation::Plant;
using simulation::PlantOptions;

std::shared_ptr<const Plant> make_plant(const ModelPtr& model, double timestep, double damping_ratio, double armature,
                                        double spring_resolution, double time_constant, double friction_time_constant, double impedance,
                                        double friction_stiffening, int noslip_iterations, double friction_scale, double ground_softness,
                                        Flag velocity_reference, Flag effort_limits, Flag joint_friction) {
  const nb::gil_scoped_release unlocked;
  PlantOptions options;
  options.timestep = timestep;
  options.damping_ratio = damping_ratio;
  options.velocity_reference = velocity_reference;
  options.effort_limits = effort_limits;
  options.joint_friction = joint_friction;
  options.armature = armature;
  options.spring_resolution = spring_resolution;
  options.contact = {time_constant,     friction_time_constant, impedance,      friction_stiffening,
                     noslip_iterations, friction_scale,         ground_softness};
  return Plant::make(model, options);
}

simulation::SimulationResult simulate(const std::shared_ptr<const Plant>& plant, const Vector& q0, const Vector& times, const Matrix& u,
                                      const std::optional<Vector>& v0, double record_interval, std::optional<double> timeout_s) {
  simulation::SimulationResult out;
  if (u.value.rows() != times.value.size() || u.value.cols() != plant->model().n_a()) {
    core::throw_invalid("u", fmt::format("shape ({}, {})", u.value.rows(), u.value.cols()),
                        fmt::format("(knots, n_a) = ({}, {})", times.value.size(), plant->model().n_a()));
  }
  const Eigen::MatrixXd columns = u.value.transpose();
  simulation::SimulationInput in{q0.value, times.value, columns};
  if (v0) in.v0 = &v0->value;
  core::RunControl control;
  if (timeout_s) control.deadline = deadline_in(*timeout_s);
  const nb::gil_scoped_release unlocked;
  simulation::Workspace work(plant);
  (void)simulation::simulate(*plant, in, {.record_interval = record_interval, .control = &control, .stop = {}}, work, out);
  return out;
}

void bind_results(nb::module_& m) {
  using simulation::PairForce;
  nb::class_<PairForce>(m, "PairForce", "Force of one pair, its contact points together.")
      .def_ro("pair", &PairForce::pair, "index into Model.pairs")
      .def_ro("normal", &PairForce::normal, "[N]")
      .def_ro("tangential", &PairForce::tangential, "[N]")
      .def_ro("force_W", &PairForce::force_W, "on A [N]")
      .def_ro("friction_W", &PairForce::friction_W, "[N]")
      .def_ro("p_WC", &PairForce::p_WC, "mean of the points, weighted by their normal forces [m]")
      .def_ro("depth", &PairForce::depth, "deepest penetration [m]");
  using Result = simulation::SimulationResult;
  nb::class_<Result>(m, "SimulationResult", "Samples of a second-order simulation.")
      .def_ro("status", &Result::status)
      .def_ro("message", &Result::message)
      .def_prop_ro(
          "times",
          [](const Result& r) -> Eigen::VectorXd {
            return Eigen::Map<const Eigen::VectorXd>(r.times.data(), static_cast<Eigen::Index>(r.times.size()));
          },
          "[s] (samples)")
      .def_prop_ro(
          "q", [](const Result& r) { return rows(r.q); }, "(samples, n_q)")
      .def_prop_ro(
          "v", [](const Result& r) { return rows(r.v); }, "(samples, n_v) [m/s, rad/s]")
      .def_prop_ro(
          "torque", [](const Result& r) { return rows(r.torque); },
          "(samples, n_a) of each motor the largest since the sample before [N m or N]")
      .def_ro("forces", &Result::forces, "per sample, by pair index; only pairs that touch")
      .def_ro("max_depth", &Result::max_depth, "[m]")
      .def_ro("steps", &Result::steps)
      .def_ro("wall_s", &Result::wall_s);
}

}  // namespace

void bind_simulation(nb::module_& m) {
  const PlantOptions options;
  const auto& contact = options.contact;
  bind_results(m);
  nb::class_<Plant>(m, "Plant", R"(A model as MuJoCo simulates it; docs/theory/simulation.md says what follows from each argument.

  timestep: [s], > 0.
  damping_ratio: of a joint spring with the inertia that its joint moves, >= 0.
  armature: inertia of every motor as its joint sees it [kg or kg m^2], >= 0; raised where a spring would turn faster than
    spring_resolution [rad] in a timestep.
  time_constant: of contacts in the normal direction [s]; friction_time_constant: in which slip dies out [s].
  impedance: in (0, 0.9999]; 1 would be rigid. friction_stiffening: of friction against the normal direction, >= 1.
  noslip_iterations: sweeps that remove the rest of the creep.
  friction_scale: factor of every coefficient of friction, >= 0.
  ground_softness: factor of both time constants for objects on fixed geometry, >= 1.
  velocity_reference: damping acts on the difference of commanded and real velocity; else on the real one.
  effort_limits: motors give Model.effort at most.
  joint_friction: robot joints have the friction and damping of their files; objects always have theirs.

Raises InvalidInput by the name of the argument.)")
      .def(nb::new_(&make_plant), "model"_a, nb::kw_only(), "timestep"_a = options.timestep, "damping_ratio"_a = options.damping_ratio,
           "armature"_a = options.armature, "spring_resolution"_a = options.spring_resolution, "time_constant"_a = contact.time_constant,
           "friction_time_constant"_a = contact.friction_time_constant, "impedance"_a = contact.impedance,
           "friction_stiffening"_a = contact.friction_stiffening, "noslip_iterations"_a = contact.noslip_iterations,
           "friction_scale"_a = contact.friction_scale, "ground_softness"_a = contact.ground_softness,
           "velocity_reference"_a = options.velocity_reference, "effort_limits"_a = options.effort_limits,
           "joint_friction"_a = options.joint_friction)
      .def_prop_ro(
          "timestep", [](const Plant& plant) { return plant.options().timestep; }, "[s]")
      .def_prop_ro("damping", &Plant::damping, nb::rv_policy::copy, "of the joint springs (n_a) [N s/m or N m s/rad]")
      .def_prop_ro("armature", &Plant::armature, nb::rv_policy::copy, "(n_a) [kg or kg m^2]");
  m.def("simulate", &simulate, "plant"_a, "q0"_a, "times"_a, "u"_a, nb::kw_only(), "v0"_a = nb::none(),
        "record_interval"_a = simulation::SimulationOptions{}.record_interval, "timeout_s"_a = nb::none(),
        R"(Second-order simulation, from q0 to the last knot.

  q0: configuration (n_q).
  times: of the knots, increasing from 0 (knots) [s].
  u: commanded joint positions, linear between knots (knots, n_a) [m or rad].
  v0: velocity in tangent coordinates (n_v) [m/s, rad/s]; None: at rest.
  record_interval: of the samples [s], > 0.
  timeout_s: [s] > 0; None: as long as it takes.

status: Solved; MaxIterations (time used up); NumericalFailure (`message`). Raises InvalidInput.

    >>> task = st.load_task("planar_pushing")
    >>> run = st.simulate(st.Plant(task.model), task.q_start, [0.0, 0.5], [[0, 0], [0, 0.1]], record_interval=0.05)
    >>> run.status, run.q.shape
    (Status.Solved, (11, 5)))");
  def_pickle<simulation::PairForce, simulation::SimulationResult>();
  def_no_pickle<Plant>("Plant", "the model and the options that it was made from");
}

}  // namespace stiction::python
