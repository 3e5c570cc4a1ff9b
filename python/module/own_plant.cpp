#include "own_plant.hpp"

#include <fmt/format.h>

#include "pickles.hpp"
#include "stiction/execution/closed_loop/part_start.hpp"
#include "stiction/execution/closed_loop/simulated_plant.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::python {

using execution::Measurement;
using execution::SimulatedPlant;

namespace {

[[noreturn]] void refuse(const char* call, nb::handle got, const char* expected) {
  core::throw_invalid(fmt::format("plant.{}", call), fmt::format("a value of type {}", nb::type_name(got.type()).c_str()), expected);
}

void make_simulated(SimulatedPlant* self, const tasks::Task& task) {
  const execution::PartedStart start = execution::part_start(task.model, task.problem.q_start, task.options.step_options(*task.model));
  new (self) SimulatedPlant(task.model, start.q);
}

void push(SimulatedPlant& plant, const std::string& body, const Vector& force_W, const std::optional<Vector>& p_BP) {
  const world::Model& model = plant.world().plant().model();
  simulation::Push out{.body = find_body(model, "body", body), .p_BP = {}, .force_W = require_vector3("force_W", force_W)};
  const world::Body& pushed = model.bodies()[static_cast<std::size_t>(out.body)];
  if (p_BP)
    out.p_BP = require_vector3("p_BP", *p_BP);
  else if (pushed.kind == world::BodyKind::Object)
    out.p_BP = model.scene().objects[static_cast<std::size_t>(pushed.owner)].p_BCom;
  else
    core::throw_invalid("p_BP", "None for a body that is no object", "a point in its frame");
  plant.hold_push(out);
}

}  // namespace

OwnPlant::OwnPlant(nb::object driver) : driver_(std::move(driver)) {
  if (driver_.is_none()) return;
  for (const char* call : {"read", "command"}) {
    if (!nb::hasattr(driver_, call))
      core::throw_invalid("plant", fmt::format("an object without {}()", call), "one with read() and command(u, period)");
  }
  if (!nb::hasattr(driver_, "real_time")) return;
  const nb::object given = driver_.attr("real_time");
  if (!is_bool(given)) refuse("real_time", given, "True or False");
  real_time_ = nb::cast<bool>(nb::bool_(given));
}

template <class Call>
bool OwnPlant::ask(const Call& call) {
  const nb::gil_scoped_acquire locked;
  try {
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    return call();
  } catch (const std::exception& error) {
    message_ = error.what();
    error_ = std::current_exception();
    return false;
  }
}

bool OwnPlant::read(Measurement& out) {
  return ask([&] {
    const nb::object measured = driver_.attr("read")();
    if (measured.is_none()) return false;
    if (!nb::isinstance<Measurement>(measured)) refuse("read()", measured, "a Measurement, or None where the robot does not answer");
    out = nb::cast<Measurement>(measured);
    return true;
  });
}

bool OwnPlant::command(execution::VectorRef u, double period) {
  return ask([&] {
    const nb::object taken = driver_.attr("command")(Eigen::VectorXd(u), period);
    if (taken.is_none()) return true;
    if (!is_bool(taken)) refuse("command()", taken, "None or True, or False where the command is not taken");
    return nb::cast<bool>(nb::bool_(taken));
  });
}

void bind_plants(nb::module_& m) {
  nb::class_<Measurement>(m, "Measurement", "State of a plant as its sensors measured it: the return value of read().")
      .def(
          "__init__",
          [](Measurement* self, double time, const Vector& q, const Vector& u, std::optional<double> object_time) {
            new (self) Measurement{time, object_time.value_or(time), q.named("q"), u.named("u")};
          },
          "time"_a, "q"_a, "u"_a, "object_time"_a = nb::none(),
          R"(A measurement for run().

  time: time on the clock of the plant at which the joints were measured [s].
  q: configuration: the objects as last seen, the joints as measured (n_q).
  u: commands in force (n_a) [rad or m].
  object_time: time at which the objects were at the poses in q [s], <= time. None: the same as `time`.)")
      .def_ro("time", &Measurement::time, "time on the clock of the plant at which the joints were measured [s]")
      .def_ro("object_time", &Measurement::object_time, "time at which the objects were at the poses in q [s]")
      .def_ro("q", &Measurement::q, "configuration: objects as last seen, joints as measured (n_q)")
      .def_ro("u", &Measurement::u, "commands in force (n_a) [rad or m]");
  nb::class_<SimulatedPlant>(
      m, "SimulatedPlant",
      "A simulation in MuJoCo that begins at rest at the start of a task; bodies that overlap there are moved apart. run() uses it if no "
      "`plant` is given.")
      .def("__init__", &make_simulated, "task"_a)
      .def(
          "read",
          [](SimulatedPlant& plant) {
            Measurement out;
            return plant.read(out) ? std::optional(out) : std::nullopt;
          },
          "Returns a Measurement, or None if the simulation has failed.")
      .def(
          "command", [](SimulatedPlant& plant, const Vector& u, double period) { return plant.command(u.named("u"), period); }, "u"_a,
          "period"_a, nb::call_guard<nb::gil_scoped_release>(),
          "Moves the commands linearly to u (n_a) [rad or m] within period [s]. Returns False if the command was not taken.")
      .def("push", &push, "body"_a, "force_W"_a, "p_BP"_a = nb::none(),
           R"(Applies a constant force to a body from now on. It replaces the force of the previous call; a zero force ends it.

  body: name of the body.
  force_W: force in the world frame [N] (3).
  p_BP: point of application in the frame of the body [m] (3). None: the centre of mass; only for objects.

    >>> task = st.load_task("planar_pushing")
    >>> plant = st.SimulatedPlant(task)
    >>> plant.push("box", [0, 5, 0])
    >>> plant.command(plant.read().u, 0.1), bool(plant.read().q[0] > task.q_start[0])
    (True, True))");
  def_pickle<Measurement>();
  def_no_pickle<SimulatedPlant>("SimulatedPlant", "the task that it was made from");
}

}  // namespace stiction::python
