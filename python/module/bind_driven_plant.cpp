#include <fmt/format.h>

#include "bindings.hpp"
#include "pickles.hpp"
#include "stiction/simulation/driven_plant.hpp"

namespace stiction::python {
namespace {

using simulation::ImpedanceOptions;
using simulation::PairForce;

/// simulation::DrivenPlant that two threads cannot use at once.
struct DrivenPlant {
  explicit DrivenPlant(simulation::DrivenPlant&& made) : plant(std::move(made)) {}
  simulation::DrivenPlant plant;
  std::atomic<bool> busy{false};
};

std::shared_ptr<DrivenPlant> make_plant(const std::shared_ptr<const simulation::Plant>& plant, double damping_ratio, double velocity_cutoff,
                                        double gain_cutoff, double period) {
  const nb::gil_scoped_release unlocked;
  const ImpedanceOptions options{damping_ratio, velocity_cutoff, gain_cutoff, period};
  return std::make_shared<DrivenPlant>(simulation::DrivenPlant(plant, options));
}

/// What can be read between two advances.
template <class R>
auto reader(R (simulation::DrivenPlant::*get)() const) {
  return [get](DrivenPlant& self) {
    const Occupied occupied(self.busy, "plant");
    return std::decay_t<R>((self.plant.*get)());
  };
}

core::Status advance(DrivenPlant& self, const Vector& command, double duration) {
  const nb::gil_scoped_release unlocked;
  const Occupied occupied(self.busy, "plant");
  return self.plant.advance(command.named("command"), duration);
}

void set_push(DrivenPlant& self, const std::string& body, const Vector& p_BP, const Vector& force_W) {
  const Occupied occupied(self.busy, "plant");
  self.plant.set_push(
      {find_body(self.plant.plant().model(), "body", body), require_vector3("p_BP", p_BP), require_vector3("force_W", force_W)});
}

}  // namespace

void bind_driven_plant(nb::module_& m) {
  using Driven = simulation::DrivenPlant;
  const ImpedanceOptions standard;
  nb::class_<DrivenPlant>(
      m, "DrivenPlant",
      R"(A simulation that you advance tick by tick: an impedance controller turns joint commands into joint torques (C.7).

Use it to test your own controller. Only one thread may use it at a time.

  plant: Plant(model, damping_ratio=0), since the impedance controller provides the damping.
  damping_ratio: damping ratio of each joint with the inertia that the joint moves, >= 0.
  velocity_cutoff, gain_cutoff: cut-off frequencies of the low-passes on joint velocities and on the damping [Hz], > 0.
  period: time between two torques, in whole time steps of the plant [s], > 0.

Raises InvalidInput, which names the argument.

    >>> task = st.load_task("planar_pushing")
    >>> plant = st.DrivenPlant(st.Plant(task.model, damping_ratio=0))
    >>> plant.reset(task.q_start)
    >>> plant.advance([0.0, 0.02], 0.1), round(plant.time, 3)
    (Status.Solved, 0.1))")
      .def(nb::new_(&make_plant), "plant"_a, nb::kw_only(), "damping_ratio"_a = standard.damping_ratio,
           "velocity_cutoff"_a = standard.velocity_cutoff, "gain_cutoff"_a = standard.gain_cutoff, "period"_a = standard.period)
      .def(
          "reset",
          [](DrivenPlant& self, const Vector& q) {
            const Occupied occupied(self.busy, "plant");
            self.plant.reset(q.named("q"));
          },
          "q"_a, "Resets the simulation: at rest in q (n_q) at time 0, without a push.")
      .def("set_push", &set_push, "body"_a, "p_BP"_a, "force_W"_a,
           "Applies a constant force force_W [N] (3) from now on, at the point p_BP of a body, in its frame [m] (3). A zero force ends it.")
      .def("advance", &advance, "command"_a, "duration"_a,
           R"(Simulates with a constant command.

  command: commanded joint positions (n_a) [rad or m].
  duration: time [s], > 0. It is rounded to whole periods of the impedance controller, at least one.

Returns Solved, or NumericalFailure: `message` gives the reason, and only reset() continues from there.)")
      .def_prop_ro("time", reader(&Driven::time), "simulated time [s]")
      .def_prop_ro("q", reader(&Driven::q), "configuration (n_q)")
      .def_prop_ro("v", reader(&Driven::v), "velocity in tangent coordinates (n_v) [m/s, rad/s]")
      .def_prop_ro("torque", reader(&Driven::torque), "joint torques (n_a) [N m or N]")
      .def_prop_ro("external", reader(&Driven::external),
                   "external torques of contacts, joint stops and the push (n_a) [N m or N]; the argument tau of Sensor.sense")
      .def_prop_ro("damping", reader(&Driven::damping), "damping of the impedance controller (n_a) [N m s/rad or N s/m]")
      .def_prop_ro("forces", reader(&Driven::forces), "contact forces of the pairs that touch, ordered by pair index")
      .def_prop_ro("message", reader(&Driven::message), "reason of a numerical failure");
  def_no_pickle<DrivenPlant>("DrivenPlant", "the model and the options that it was made from");
}

}  // namespace stiction::python
