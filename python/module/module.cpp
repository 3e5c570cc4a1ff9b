#include "bind_run.hpp"
#include "bind_touch.hpp"
#include "stiction/core/file_fault.hpp"
#include "stiction/core/status.hpp"
#include "stiction/core/version.hpp"

namespace nb = nanobind;

namespace {

/// Raises InvalidInput. Messages quote files, whose bytes need not be UTF-8.
void raise_invalid_input(const std::exception_ptr& thrown, void* type) {
  const auto raise = [type](const stiction::core::InvalidInput& error) {
    const std::string_view what = error.what();
    const nb::object text = nb::steal(PyUnicode_DecodeUTF8(what.data(), static_cast<Py_ssize_t>(what.size()), "backslashreplace"));
    PyErr_SetObject(static_cast<PyObject*>(type), text.ptr());
  };
  try {
    std::rethrow_exception(thrown);
  } catch (const stiction::core::InvalidInput& error) {
    raise(error);
  } catch (const std::filesystem::filesystem_error& error) {
    raise(stiction::core::to_invalid_input(error));
  }
}

}  // namespace

NB_MODULE(_core, m) {
  using stiction::core::Status;
  nb::set_leak_warnings(
      false);  // what threads of an interrupted program hold is freed with the process, and is no fault of who interrupts it
  m.doc() = "Robot motion through contact.";
  m.def("version", &stiction::core::version, "Returns the version of the library as MAJOR.MINOR.PATCH.");
  const nb::exception<stiction::core::InvalidInput> invalid(m, "InvalidInput", PyExc_ValueError);
  nb::register_exception_translator(raise_invalid_input, invalid.ptr());
  nb::enum_<Status>(m, "Status", "Outcome of a numerical procedure. Wrong arguments raise InvalidInput instead.")
      .value("Solved", Status::Solved, "the procedure reached its tolerance or goal")
      .value("MaxIterations", Status::MaxIterations,
             "the budget of iterations, nodes or time was used up; the best result so far is returned")
      .value("Infeasible", Status::Infeasible, "there is no solution, as a certificate proves")
      .value("NumericalFailure", Status::NumericalFailure, "the computation failed; do not use the results")
      .value("Cancelled", Status::Cancelled, "the caller stopped the procedure; the best result so far is returned");
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
