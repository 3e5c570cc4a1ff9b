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

std::vector<Eigen::VectorXd> vectors_of(const Eigen::MatrixXd& rows) {
  std::vector<Eigen::VectorXd> out;
  for (const auto& row : rows.rowwise()) out.emplace_back(row.transpose());
  return out;
}

/// The start is that of the reference, the horizon its length, and the guess stays at the start.
void follow(const world::Model& model, const Matrix& reference, Eigen::VectorXd& q_start, trajopt::OptimizeInput& input) {
  core::require_size("reference.shape[1]", reference.named("reference").cols(), model.n_q());
  if (reference.named("reference").rows() < 2)
    core::throw_invalid("reference", fmt::format("{} configurations", reference.named("reference").rows()),
                        "at least two, the start first");
  input.reference = vectors_of(reference.named("reference"));
  q_start = input.reference[0];
  const int horizon = static_cast<int>(reference.named("reference").rows()) - 1;
  input.u_guess = trajopt::constant_inputs(model, q_start, horizon);
}

void take_guess(const world::Model& model, const Matrix& u_guess, trajopt::OptimizeInput& input) {
  core::require_size("u_guess.shape[1]", u_guess.named("u_guess").cols(), model.n_a());
  core::require_size("u_guess.shape[0]", u_guess.named("u_guess").rows(), static_cast<long>(input.u_guess.size()));
  input.u_guess = vectors_of(u_guess.named("u_guess"));
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
    core::require_size("u_before", u_before->named("u_before").size(), task.model->n_a());
    input.u_before = &u_before->named("u_before");
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
  nb::class_<CostTerms>(m, "CostTerms", "Terms of the cost of a trajectory (T.1).")
      .def_ro("objects", &CostTerms::objects, "tracking error of the objects before the final time")
      .def_ro("objects_final", &CostTerms::objects_final, "tracking error of the objects at the final time")
      .def_ro("robots", &CostTerms::robots, "tracking error of the robots before the final time")
      .def_ro("robots_final", &CostTerms::robots_final, "tracking error of the robots at the final time")
      .def_ro("input", &CostTerms::input, "changes of the command between steps")
      .def_prop_ro("total", &CostTerms::total, "sum of the terms");
  nb::class_<IterationLog>(m, "IterationLog", "One iteration of optimize().")
      .def_ro("cost", &IterationLog::cost, "cost of the trajectory after this iteration")
      .def_ro("best", &IterationLog::best, "lowest total cost so far")
      .def_ro("length", &IterationLog::length, "length of the accepted step, 1: the full step; 0: no step was accepted")
      .def_ro("sharpness", &IterationLog::sharpness,
              "smoothing of the iteration: kappa [1/J], or the largest standard deviation of u [rad or m]; 0: exact")
      .def_ro("qp_iterations", &IterationLog::qp_iterations, "number of iterations of the QP solver")
      .def_ro("failed_models", &IterationLog::failed_models, "number of time steps whose local model had no solution")
      .def_ro("elapsed_s", &IterationLog::elapsed_s, "wall time since the start [s]");
  nb::class_<OptimizeResult>(m, "OptimizeResult", "Result of optimize(): the best trajectory and the history of the iterations.")
      .def_ro("status", &OptimizeResult::status)
      .def_prop_ro(
          "q", [](const OptimizeResult& r) { return rows_of(r.q); }, "configurations of the best trajectory (T + 1, n_q)")
      .def_prop_ro(
          "u", [](const OptimizeResult& r) { return rows_of(r.u); }, "commands of the best trajectory (T, n_a) [m or rad]")
      .def_ro("cost", &OptimizeResult::cost, "cost of the best trajectory")
      .def_ro("history", &OptimizeResult::history, "iterations, the initial guess first")
      .def_ro("steps", &OptimizeResult::steps, "number of steps that were computed")
      .def_ro("linearisations", &OptimizeResult::linearisations, "number of local models that were computed")
      .def_ro("wall_s", &OptimizeResult::wall_s, "wall time [s]")
      .def("__repr__", [](const OptimizeResult& r) {
        return fmt::format("<stiction.OptimizeResult: {}, cost {:.6g}>", core::to_string(r.status), r.cost.total());
      });
  m.def("optimize", &optimize, "task"_a, nb::kw_only(), "scheme"_a = nb::none(), "solver"_a = nb::none(), "iterations"_a = nb::none(),
        "forces"_a = false, "seed"_a = nb::none(), "timeout_s"_a = 60.0, "threads"_a = 0, "on_progress"_a = nb::none(),
        "section"_a = nb::none(), "reference"_a = nb::none(), "u_guess"_a = nb::none(), "u_before"_a = nb::none(),
        R"(Optimises a trajectory through contact by iterative MPC (iMPC, Alg. 1).

Use it to improve a motion near an initial guess; plan() searches for a motion from scratch. The section `optimize` of the task gives the
weights, the horizon and the defaults.

  task: Task with a section `optimize`.
  scheme: local model: exact, analytic, randomized-first or randomized-zeroth. None: as in the task.
  solver: sweep or receding. None: as in the task.
  iterations: largest number of iterations. None: as in the task.
  forces: True: use the contact trust region.
  seed: of the randomised schemes. None: as in the task.
  timeout_s: largest wall time [s], > 0.
  threads: 0: all cores. The result does not depend on this number.
  on_progress: function that is called with Progress. Ctrl-C, an error in the function or the return value False stop the optimisation.
  section: dict with the keys of the section `optimize`, which replaces the section of the task.
  reference: configurations to track, the start first (T + 1, n_q). The step has the options of the planner then. None: the goal at all times.
  u_guess: initial guess of the commands (T, n_a) [m or rad]. None: the commands of the start at all times.
  u_before: command before the first one (n_a) [m or rad]. None: the joint positions of the start.

Returns an OptimizeResult. Its status is Solved; or MaxIterations (time used up) or Cancelled, with the best trajectory so far. Raises
InvalidInput.

    >>> result = st.optimize(st.load_task("impc_planar_pushing"), iterations=2)
    >>> result.status, len(result.q) == len(result.u) + 1
    (Status.Solved, True))");
  def_pickle<CostTerms, IterationLog, OptimizeResult>();
}

}  // namespace stiction::python
