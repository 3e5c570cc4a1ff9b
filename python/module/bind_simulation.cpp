#include <fmt/format.h>

#include "bindings.hpp"
#include "pickles.hpp"
#include "stiction/simulation/simulation.hpp"
#include "watcher.hpp"

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
  if (u.named("u").rows() != times.named("times").size() || u.named("u").cols() != plant->model().n_a()) {
    core::throw_invalid("u", fmt::format("shape ({}, {})", u.named("u").rows(), u.named("u").cols()),
                        fmt::format("(knots, n_a) = ({}, {})", times.named("times").size(), plant->model().n_a()));
  }
  const Eigen::MatrixXd columns = u.named("u").transpose();
  simulation::SimulationInput in{q0.named("q0"), times.named("times"), columns};
  if (v0) in.v0 = &v0->named("v0");
  Interrupt interrupt;
  const core::RunControl control = interrupt.control(timeout_s);
  const nb::gil_scoped_release unlocked;
  simulation::Workspace work(plant);
  (void)simulation::simulate(*plant, in, {.record_interval = record_interval, .control = &control, .stop = {}}, work, out);
  interrupt.rethrow();
  return out;
}

void bind_results(nb::module_& m) {
  using simulation::PairForce;
  nb::class_<PairForce>(m, "PairForce", "Contact force of one pair of geometries A and B, summed over its contact points.")
      .def_ro("pair", &PairForce::pair, "index into Model.pairs")
      .def_ro("normal", &PairForce::normal, "normal force [N]")
      .def_ro("tangential", &PairForce::tangential, "magnitude of the friction force [N]")
      .def_ro("force_W", &PairForce::force_W, "contact force on A, in W [N] (3)")
      .def_ro("friction_W", &PairForce::friction_W, "friction force, in W [N] (3)")
      .def_ro("p_WC", &PairForce::p_WC, "mean contact point in W, weighted by the normal forces [m] (3)")
      .def_ro("depth", &PairForce::depth, "deepest penetration [m]");
  using Result = simulation::SimulationResult;
  nb::class_<Result>(m, "SimulationResult", "Result of simulate(): samples of the motion and of the forces.")
      .def_ro("status", &Result::status)
      .def_ro("message", &Result::message, "reason of a numerical failure")
      .def_prop_ro(
          "times",
          [](const Result& r) -> Eigen::VectorXd {
            return Eigen::Map<const Eigen::VectorXd>(r.times.data(), static_cast<Eigen::Index>(r.times.size()));
          },
          "times of the samples [s] (samples)")
      .def_prop_ro(
          "q", [](const Result& r) { return rows(r.q); }, "configurations (samples, n_q)")
      .def_prop_ro(
          "v", [](const Result& r) { return rows(r.v); }, "velocities in tangent coordinates (samples, n_v) [m/s, rad/s]")
      .def_prop_ro(
          "torque", [](const Result& r) { return rows(r.torque); },
          "largest torque of each motor since the previous sample (samples, n_a) [N m or N]")
      .def_ro("forces", &Result::forces, "for each sample, the forces of the pairs that touch, ordered by pair index")
      .def_ro("max_depth", &Result::max_depth, "deepest penetration [m]")
      .def_ro("steps", &Result::steps, "number of time steps")
      .def_ro("wall_s", &Result::wall_s, "wall time [s]");
}

}  // namespace

void bind_simulation(nb::module_& m) {
  const PlantOptions options;
  const auto& contact = options.contact;
  bind_results(m);
  nb::class_<Plant>(
      m, "Plant", R"(A model prepared for second-order simulation in MuJoCo. docs/theory/simulation.md explains the effect of each argument.

  model: Model of the scene.
  timestep: time step [s], > 0.
  damping_ratio: damping ratio of each joint spring with the inertia that the joint moves, >= 0.
  armature: least inertia of every motor, reflected to its joint [kg or kg m^2], >= 0. A joint has more if its file says so, or if its
    spring would turn by more than spring_resolution [rad] in a time step.
  time_constant: time constant of contacts in the normal direction [s].
  friction_time_constant: time constant with which slip decays [s].
  impedance: contact impedance, in (0, 0.9999]; 1 would be rigid.
  friction_stiffening: stiffness of friction relative to the normal direction, >= 1.
  noslip_iterations: number of solver sweeps that remove the remaining creep.
  friction_scale: factor of every coefficient of friction, >= 0.
  ground_softness: factor of both time constants for objects on fixed geometry, >= 1.
  velocity_reference: True: joint damping acts on the difference of commanded and actual velocity. False: it acts on the actual velocity.
  effort_limits: True: no motor gives more than Model.effort.
  joint_friction: True: robot joints have the dry friction of their files, and servos do not overcome their damping. Joints of objects always have
    both.

Raises InvalidInput, which names the argument.)")
      .def(nb::new_(&make_plant), "model"_a, nb::kw_only(), "timestep"_a = options.timestep, "damping_ratio"_a = options.damping_ratio,
           "armature"_a = options.armature, "spring_resolution"_a = options.spring_resolution, "time_constant"_a = contact.time_constant,
           "friction_time_constant"_a = contact.friction_time_constant, "impedance"_a = contact.impedance,
           "friction_stiffening"_a = contact.friction_stiffening, "noslip_iterations"_a = contact.noslip_iterations,
           "friction_scale"_a = contact.friction_scale, "ground_softness"_a = contact.ground_softness,
           "velocity_reference"_a = options.velocity_reference, "effort_limits"_a = options.effort_limits,
           "joint_friction"_a = options.joint_friction)
      .def_prop_ro(
          "timestep", [](const Plant& plant) { return plant.options().timestep; }, "time step [s]")
      .def_prop_ro("damping", &Plant::damping, nb::rv_policy::copy, "damping of the joint springs (n_a) [N s/m or N m s/rad]")
      .def_prop_ro("armature", &Plant::armature, nb::rv_policy::copy, "inertia of the motors (n_a) [kg or kg m^2]");
  m.def("simulate", &simulate, "plant"_a, "q0"_a, "times"_a, "u"_a, nb::kw_only(), "v0"_a = nb::none(),
        "record_interval"_a = simulation::SimulationOptions{}.record_interval, "timeout_s"_a = nb::none(),
        R"(Simulates commands in MuJoCo, with inertia and impacts, from q0 to the last knot.

  plant: Plant of the model.
  q0: configuration at the start (n_q).
  times: times of the knots, increasing from 0 (knots) [s].
  u: commanded joint positions at the knots, linear between them (knots, n_a) [m or rad].
  v0: velocity at the start in tangent coordinates (n_v) [m/s, rad/s]. None: at rest.
  record_interval: time between two samples of the result [s], > 0.
  timeout_s: largest wall time [s], > 0. None: no limit.

Returns a SimulationResult. Its status is Solved; MaxIterations: the time was used up; or NumericalFailure: `message` gives the reason.
Raises InvalidInput.

    >>> task = st.load_task("planar_pushing")
    >>> run = st.simulate(st.Plant(task.model), task.q_start, [0.0, 0.5], [[0, 0], [0, 0.1]], record_interval=0.05)
    >>> run.status, run.q.shape
    (Status.Solved, (11, 5)))");
  def_pickle<simulation::PairForce, simulation::SimulationResult>();
  def_no_pickle<Plant>("Plant", "the model and the options that it was made from");
}

}  // namespace stiction::python
