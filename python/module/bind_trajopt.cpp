#include <fmt/format.h>
#include <nanobind/stl/unique_ptr.h>

#include "pickles.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/trajopt/optimize.hpp"
#include "stiction/world/yaml.hpp"
#include "watcher.hpp"
#include "yaml_text.hpp"

namespace stiction::python {
namespace {

using trajopt::CostTerms;
using trajopt::IterationLog;
using trajopt::OptimizeResult;

std::vector<Eigen::VectorXd> vectors_of(const Matrix& rows) {
  std::vector<Eigen::VectorXd> out;
  for (const auto& row : rows.value.rowwise()) out.emplace_back(row.transpose());
  return out;
}

/// The start is that of the reference, the horizon its length, and the guess stays at the start.
void follow(const world::Model& model, const Matrix& reference, Eigen::VectorXd& q_start, trajopt::OptimizeInput& input) {
  core::require_size("reference.shape[1]", reference.value.cols(), model.n_q());
  if (reference.value.rows() < 2)
    core::throw_invalid("reference", fmt::format("{} configurations", reference.value.rows()), "at least two, the start first");
  input.reference = vectors_of(reference);
  q_start = input.reference[0];
  const int horizon = static_cast<int>(reference.value.rows()) - 1;
  input.u_guess = trajopt::constant_inputs(model, q_start, horizon);
}

void take_guess(const world::Model& model, const Matrix& u_guess, trajopt::OptimizeInput& input) {
  core::require_size("u_guess.shape[1]", u_guess.value.cols(), model.n_a());
  core::require_size("u_guess.shape[0]", u_guess.value.rows(), static_cast<long>(input.u_guess.size()));
  input.u_guess = vectors_of(u_guess);
}

std::unique_ptr<OptimizeResult> optimize(const tasks::Task& task, std::optional<std::string> scheme, std::optional<std::string> solver,
                                         std::optional<int> iterations, Flag forces, std::optional<std::uint64_t> seed, double timeout_s,
                                         int threads, const Callback& on_progress, const std::optional<nb::dict>& section,
                                         const std::optional<Matrix>& reference, const std::optional<Matrix>& u_guess,
                                         const std::optional<Vector>& u_before) {
  tasks::Task chosen = task;
  if (section)
    chosen.optimize = tasks::read_optimize_setup(world::YamlNode::parse(yaml_text(*section), std::filesystem::path()), *task.model);
  auto out = std::make_unique<OptimizeResult>();
  Eigen::VectorXd q_start = chosen.problem.q_start;
  const auto standard = tasks::make_optimize_input(chosen);
  trajopt::OptimizeInput input{q_start, standard.u_guess, standard.reference, nullptr};
  if (u_before) {
    core::require_size("u_before", u_before->value.size(), task.model->n_a());
    input.u_before = &u_before->value;
  }
  if (reference) {
    follow(*chosen.model, *reference, q_start, input);
    chosen.optimize->horizon = static_cast<int>(input.u_guess.size());
    chosen.optimize->options.step = task.options.step_options(*task.model);
  }
  if (u_guess) take_guess(*chosen.model, *u_guess, input);
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
        "section"_a = nb::none(), "reference"_a = nb::none(), "u_guess"_a = nb::none(), "u_before"_a = nb::none(),
        R"(Optimises a trajectory by the section `optimize` of the task (iMPC, Alg. 1).

  scheme: exact, analytic, randomized-first or randomized-zeroth; solver: sweep or receding; iterations: at most; None: as the task says.
  forces: with the contact trust region.
  seed: of the randomised schemes.
  timeout_s: [s] > 0.
  threads: 0 for all cores; the result does not depend on it.
  on_progress: called with Progress; Ctrl-C and an error in it stop the run.
  section: in place of the section `optimize` of the task, a dict with its keys.
  reference: configurations to follow, the start first (T + 1, n_q), with the dynamics of the planner; None: the goal all the time. u_guess: commands to begin with (T, n_a); None:
    those of the start all the time. u_before: the command before the first one (n_a); None: the joints of the start.

status: Solved; MaxIterations (time used up) and Cancelled: the best trajectory so far. Raises InvalidInput.

    >>> result = st.optimize(st.load_task("impc_planar_pushing"), iterations=2)
    >>> result.status, len(result.q) == len(result.u) + 1
    (Status.Solved, True))");
  def_pickle<CostTerms, IterationLog, OptimizeResult>();
}

}  // namespace stiction::python
