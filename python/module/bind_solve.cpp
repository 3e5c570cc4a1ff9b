#include <fmt/format.h>
#include <nanobind/stl/unique_ptr.h>

#include <algorithm>

#include "pickles.hpp"
#include "plan.hpp"
#include "planner_options.hpp"
#include "stiction/tasks/lint.hpp"
#include "stiction/tasks/solve.hpp"
#include "watcher.hpp"

namespace stiction::python {
namespace {

using tasks::SolveRun;

/// A try and what its plan belongs to.
struct SolveTry {
  std::shared_ptr<const tasks::Task> task;
  tasks::SolveTry result;

  std::shared_ptr<Plan> plan() const {
    planning::PlannerOptions options = task->options;
    options.seed = result.seed;
    return std::make_shared<Plan>(*task, options, result.result);
  }
};

struct SolveResult {
  std::shared_ptr<const tasks::Task> task;
  tasks::SolveResult result;
};

std::unique_ptr<SolveResult> solve(const tasks::Task& given, const std::optional<OptionsLike>& options, std::optional<std::uint64_t> seed,
                                   int tries, const std::vector<double>& friction, double speed, int threads, double timeout_s,
                                   const Callback& on_progress) {
  core::require_positive("speed", speed);
  auto task = std::make_shared<tasks::Task>(given);
  if (options) task->options = options_of({given.model, given.options}, *options);
  tasks::SolveOptions how;
  how.seed = seed.value_or(task->options.seed);
  how.tries = tries;
  how.friction = friction;
  how.speed = speed;
  how.threads = threads;
  Watcher watcher(on_progress);
  const core::RunControl control = watcher.control(timeout_s);
  how.on_stage = [&control](std::uint64_t, tasks::SolveStage, const core::Progress& progress) { control.on_progress(progress); };
  auto out = std::make_unique<SolveResult>(SolveResult{task, {}});
  {
    const nb::gil_scoped_release unlocked;
    (void)tasks::solve(*task, how, control, out->result);  // the status is in the result
  }
  watcher.rethrow();
  return out;
}

void bind_lint(nb::module_& m) {
  nb::class_<tasks::Finding>(m, "Finding", "Likely mistake in a task, as lint() reports it.")
      .def_ro("kind", &tasks::Finding::kind, "kind of the mistake")
      .def_ro("message", &tasks::Finding::message, "field or body, the value that was found, and the value that was likely meant")
      .def_ro("where", &tasks::Finding::where, "start or goal, if the mistake is in one of them; otherwise empty")
      .def_ro("names", &tasks::Finding::names, "names of the geometries (body/geometry) or of the object")
      .def_ro("p_W", &tasks::Finding::p_W, "place of an overlap or a gap in W, halfway between the nearest points [m] (3)")
      .def_ro("amount", &tasks::Finding::amount, "depth of an overlap, width of a gap, or distance by which the robot cannot reach [m]")
      .def("__repr__", [](const tasks::Finding& f) { return fmt::format("<stiction.Finding: {}: {}>", f.kind, f.message); });
  m.def(
      "lint", [](const tasks::Task& task) { return tasks::lint(task); }, "task"_a, nb::call_guard<nb::gil_scoped_release>(),
      R"(Checks a task for likely mistakes before you plan it: overlaps, objects without support, goals out of reach, and wrong units.

Returns a list of Finding; an empty list if nothing was found.

    >>> st.lint(st.load_task("planar_pushing"))
    [])");
}

}  // namespace

void bind_solve(nb::module_& m) {
  bind_lint(m);
  nb::class_<SolveRun>(m, "SolveRun", "One run of a plan in the second-order simulation, without feedback.")
      .def_ro("friction", &SolveRun::friction, "factor of every coefficient of friction")
      .def_ro("status", &SolveRun::status, "Solved: the run came to its end")
      .def_ro("reached", &SolveRun::reached, "True: the object is within the tolerances of the goal")
      .def_ro("dropped", &SolveRun::dropped, "True: an object fell")
      .def_ro("lost", &SolveRun::lost, "True: the object is too far from its plan, and the run was ended")
      .def_ro("duration_s", &SolveRun::duration_s, "simulated time [s]")
      .def_ro("error", &SolveRun::error, "distance of the object from the goal at the end");
  nb::class_<SolveTry>(m, "SolveTry", "Result of solve() for one seed.")
      .def_prop_ro(
          "seed", [](const SolveTry& t) { return t.result.seed; }, "seed of the search")
      .def_prop_ro(
          "status", [](const SolveTry& t) { return t.result.result.status; }, "status of the search")
      .def_prop_ro(
          "reason", [](const SolveTry& t) { return t.result.result.reason; }, "why the search has no solution")
      .def_prop_ro("plan", &SolveTry::plan, "refined plan, if there is one")
      .def_prop_ro(
          "accepted", [](const SolveTry& t) { return t.result.accepted; }, "True: check_plan() accepts the plan")
      .def_prop_ro(
          "runs", [](const SolveTry& t) { return t.result.runs; },
          "one run for each friction factor; only the first run if that misses the goal")
      .def_prop_ro(
          "holds", [](const SolveTry& t) { return t.result.holds(); }, "True: every run reached the goal")
      .def_prop_ro(
          "plan_s", [](const SolveTry& t) { return t.result.plan_s; }, "wall time of planning [s]")
      .def_prop_ro(
          "refine_s", [](const SolveTry& t) { return t.result.refine_s; }, "wall time of refinement [s]")
      .def_prop_ro(
          "simulate_s", [](const SolveTry& t) { return t.result.simulate_s; }, "wall time of simulation [s]");
  nb::class_<SolveResult>(m, "SolveResult", "Result of solve(): the best try and all tries.")
      .def_prop_ro(
          "status", [](const SolveResult& r) { return r.result.status; }, "see solve()")
      .def_prop_ro(
          "best",
          [](const SolveResult& r) {
            return SolveTry{r.task, r.result.best};
          },
          "the first try whose runs all reach the goal, or else the best try")
      .def_prop_ro(
          "tries",
          [](const SolveResult& r) {
            std::vector<SolveTry> out;
            for (const auto& t : r.result.tries) out.push_back({r.task, t});
            return out;
          },
          "all tries, in the order of their seeds")
      .def_prop_ro(
          "wall_s", [](const SolveResult& r) { return r.result.wall_s; }, "wall time [s]")
      .def("__repr__", [](const SolveResult& r) {
        return fmt::format("<stiction.SolveResult: {}, seed {}, {} tries>", core::to_string(r.result.status), r.result.best.seed,
                           r.result.tries.size());
      });
  const tasks::SolveOptions standard;
  m.def("solve", &solve, "task"_a, nb::kw_only(), "options"_a = nb::none(), "seed"_a = nb::none(), "tries"_a = standard.tries,
        "friction"_a = standard.friction, "speed"_a = standard.speed, "threads"_a = 0, "timeout_s"_a = 120.0, "on_progress"_a = nb::none(),
        R"(Searches for a plan that reaches its goal in the second-order simulation, without feedback.

For one seed after the other it plans, refines, checks and simulates, until a plan reaches the goal under every friction factor.

  task: Task.
  options: of the planner: PlannerOptions, or a dict with the options to change. None: the options of the task.
  seed: of the first try; the following tries count up from it. None: the seed of the options.
  tries: largest number of tries, >= 1.
  friction: factors of every coefficient of friction, >= 0. The plan has to reach the goal with each of them.
  speed: of the simulated runs, a factor on the full speed that follows from the object and the motors (E.13), > 0. A factor above 1 makes
    only pushes faster.
  threads: 0: all cores. The result does not depend on this number.
  timeout_s: largest wall time of all tries [s], > 0.
  on_progress: function that is called with Progress. Ctrl-C, an error in the function or the return value False stop the search.

Returns a SolveResult. Its status is Solved: all runs of `best` reach the goal; MaxIterations: no such plan was found, or the time was used
up; or Cancelled. Raises InvalidInput.

    >>> found = st.solve(st.load_task("planar_pushing"), seed=0, tries=1, speed=20.0)
    >>> [(one.seed, one.status) for one in found.tries]
    [(0, Status.Solved)])");
  def_pickle<tasks::Finding, SolveRun, SolveTry, SolveResult>();
}

}  // namespace stiction::python
