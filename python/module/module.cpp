#include "bind_run.hpp"
#include "bind_touch.hpp"
#include "stiction/core/status.hpp"
#include "stiction/core/version.hpp"

NB_MODULE(_core, m) {
  namespace nb = nanobind;
  using stiction::core::Status;
  nb::set_leak_warnings(
      false);  // what threads of an interrupted program hold is freed with the process, and is no fault of who interrupts it
  m.doc() = "Robot motion through contact.";
  m.def("version", &stiction::core::version, "of the library, as MAJOR.MINOR.PATCH");
  nb::exception<stiction::core::InvalidInput>(m, "InvalidInput", PyExc_ValueError);
  nb::enum_<Status>(m, "Status", "Outcome of a numerical procedure; mistakes of the caller are InvalidInput.")
      .value("Solved", Status::Solved, "the stated tolerance holds")
      .value("MaxIterations", Status::MaxIterations, "stopped at the iteration, node or time budget; the best result so far is returned")
      .value("Infeasible", Status::Infeasible, "proved by a certificate")
      .value("NumericalFailure", Status::NumericalFailure, "arithmetic broke down; results are not to be used")
      .value("Cancelled", Status::Cancelled, "the caller asked to stop; the best result so far is returned");
  stiction::python::bind_world(m);
  stiction::python::bind_visuals(m);
  stiction::python::bind_dynamics(m);
  stiction::python::bind_batch(m);
  stiction::python::bind_simulation(m);
  stiction::python::bind_driven_plant(m);
  stiction::python::bind_tasks(m);
  stiction::python::bind_planning(m);
  stiction::python::bind_trajopt(m);
  stiction::python::bind_solve(m);
  stiction::python::bind_execution(m);
  stiction::python::bind_run(m);
  stiction::python::bind_control(m);
  stiction::python::bind_control_run(m);
  stiction::python::bind_touch(m);
  stiction::python::bind_guarded(m);
  stiction::python::bind_sensing(m);
}
