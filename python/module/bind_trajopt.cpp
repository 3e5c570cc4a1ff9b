#include <fmt/format.h>
#include <nanobind/stl/unique_ptr.h>

#include "pickles.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/trajopt/optimize.hpp"
#include "watcher.hpp"

namespace stiction::python {
namespace {

using trajopt::CostTerms;
using trajopt::IterationLog;
using trajopt::OptimizeResult;

std::unique_ptr<OptimizeResult> optimize(const tasks::Task& task, std::optional<std::string> scheme, std::optional<std::string> solver,
                                         std::optional<int> iterations, Flag forces, std::optional<std::uint64_t> seed, double timeout_s,
                                         int threads, const Callback& on_progress) {
  tasks::Task chosen = task;
  auto out = std::make_unique<OptimizeResult>();
  const auto input = tasks::make_optimize_input(chosen);
  tasks::OptimizeSetup& setup = *chosen.optimize;
  if (scheme) setup.choose(tasks::parse_scheme("scheme", *scheme));
  if (solver) setup.options.solver = tasks::parse_solver("solver", *solver);
  if (forces && !setup.options.forces) setup.options.forces.emplace();
  if (iterations) setup.options.iterations = *iterations;
  if (seed) setup.set_seed(*seed);
  setup.options.threads = threads;
  setup.options.validate(*chosen.model);
  Watcher watcher(on_progress);
  const core::RunControl control = watcher.control(timeout_s);
  {
    const nb::gil_scoped_release unlocked;
    trajopt::OptimizeWorkspace work(chosen.model, threads);
    (void)trajopt::optimize(*chosen.model, input, setup.options, control, work, *out);  // the status is in the result
  }
  watcher.rethrow();
  return out;
}

Rows rows_of(const std::vector<Eigen::VectorXd>& vectors) {
  return rows(vectors, vectors.empty() ? 0 : vectors[0].size(), [](const auto& v) { return v.transpose(); });
}

}  // namespace

void bind_trajopt(nb::module_& m) {
  nb::class_<CostTerms>(m, "CostTerms", "Parts of the cost (T.1) of a trajectory.")
      .def_ro("objects", &CostTerms::objects, "tracking of the objects before the end")
      .def_ro("objects_final", &CostTerms::objects_final, "and at the end")
      .def_ro("robots", &CostTerms::robots)
      .def_ro("robots_final", &CostTerms::robots_final)
      .def_ro("input", &CostTerms::input, "changes of the command")
      .def_prop_ro("total", &CostTerms::total);
  nb::class_<IterationLog>(m, "IterationLog", "What an iteration came to.")
      .def_ro("cost", &IterationLog::cost, "of the trajectory after this iteration")
      .def_ro("best", &IterationLog::best, "lowest total so far")
      .def_ro("length", &IterationLog::length, "of the accepted step; 0: none was")
      .def_ro("sharpness", &IterationLog::sharpness, "kappa [1/J], or the standard deviation of u")
      .def_ro("qp_iterations", &IterationLog::qp_iterations)
      .def_ro("failed_models", &IterationLog::failed_models)
      .def_ro("elapsed_s", &IterationLog::elapsed_s);
  nb::class_<OptimizeResult>(m, "OptimizeResult", "The best trajectory of an optimisation.")
      .def_ro("status", &OptimizeResult::status)
      .def_prop_ro(
          "q", [](const OptimizeResult& r) { return rows_of(r.q); }, "configurations of the best trajectory (T + 1, n_q)")
      .def_prop_ro(
          "u", [](const OptimizeResult& r) { return rows_of(r.u); }, "commands (T, n_a)")
      .def_ro("cost", &OptimizeResult::cost)
      .def_ro("history", &OptimizeResult::history, "the guess first")
      .def_ro("steps", &OptimizeResult::steps)
      .def_ro("linearisations", &OptimizeResult::linearisations)
      .def_ro("wall_s", &OptimizeResult::wall_s)
      .def("__repr__", [](const OptimizeResult& r) {
        return fmt::format("<stiction.OptimizeResult: {}, cost {:.6g}>", core::to_string(r.status), r.cost.total());
      });
  m.def("optimize", &optimize, "task"_a, nb::kw_only(), "scheme"_a = nb::none(), "solver"_a = nb::none(), "iterations"_a = nb::none(),
        "forces"_a = false, "seed"_a = nb::none(), "timeout_s"_a = 60.0, "threads"_a = 0, "on_progress"_a = nb::none(),
        R"(Optimises a trajectory by the section `optimize` of the task (iMPC, Alg. 1).

  scheme: exact, analytic, randomized-first or randomized-zeroth; solver: sweep or receding; iterations: at most; None: as the task says.
  forces: with the contact trust region.
  seed: of the randomised schemes.
  timeout_s: [s] > 0.
  threads: 0 for all cores; the result does not depend on it.
  on_progress: called with Progress; Ctrl-C and an error in it stop the run.

status: Solved; MaxIterations (time used up) and Cancelled: the best trajectory so far. Raises InvalidInput.

    >>> result = st.optimize(st.load_task("impc_planar_pushing"), iterations=2)
    >>> result.status, len(result.q) == len(result.u) + 1
    (Status.Solved, True))");
  def_pickle<CostTerms, IterationLog, OptimizeResult>();
}

}  // namespace stiction::python
