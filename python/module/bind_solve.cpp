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
  nb::class_<tasks::Finding>(m, "Finding", "Something in a task that is hardly what was meant.")
      .def_ro("kind", &tasks::Finding::kind)
      .def_ro("message", &tasks::Finding::message, "field or body, what was found, what was likely meant")
      .def_ro("where", &tasks::Finding::where, "start or goal, where it is a matter of one of them; else empty")
      .def_ro("names", &tasks::Finding::names, "geometries (body/geometry) or the object that it is about")
      .def_ro("p_W", &tasks::Finding::p_W, "of an overlap or a gap, halfway between the nearest points [m] (3)")
      .def_ro("amount", &tasks::Finding::amount, "depth of an overlap, width of a gap, or what is missing to reach [m]")
      .def("__repr__", [](const tasks::Finding& f) { return fmt::format("<stiction.Finding: {}: {}>", f.kind, f.message); });
  m.def(
      "lint", [](const tasks::Task& task) { return tasks::lint(task); }, "task"_a, nb::call_guard<nb::gil_scoped_release>(),
      "Looks at a task without planning it: overlaps, objects that nothing supports, goals that nothing reaches, units that look wrong."
      R"(

    >>> st.lint(st.load_task("planar_pushing"))
    [])");
}

}  // namespace

void bind_solve(nb::module_& m) {
  bind_lint(m);
  nb::class_<SolveRun>(m, "SolveRun", "One run of a plan in the second-order simulation.")
      .def_ro("friction", &SolveRun::friction, "factor of every coefficient of friction")
      .def_ro("status", &SolveRun::status)
      .def_ro("reached", &SolveRun::reached, "the goal, within its tolerances")
      .def_ro("dropped", &SolveRun::dropped, "an object fell")
      .def_ro("lost", &SolveRun::lost, "the object left the plan behind")
      .def_ro("duration_s", &SolveRun::duration_s, "simulated [s]")
      .def_ro("error", &SolveRun::error, "of the object at the end");
  nb::class_<SolveTry>(m, "SolveTry", "What became of one seed.")
      .def_prop_ro("seed", [](const SolveTry& t) { return t.result.seed; })
      .def_prop_ro(
          "status", [](const SolveTry& t) { return t.result.result.status; }, "of the search")
      .def_prop_ro("reason", [](const SolveTry& t) { return t.result.result.reason; })
      .def_prop_ro("plan", &SolveTry::plan, "the refined plan where there is one")
      .def_prop_ro(
          "accepted", [](const SolveTry& t) { return t.result.accepted; }, "by check_plan()")
      .def_prop_ro(
          "runs", [](const SolveTry& t) { return t.result.runs; }, "the first alone where it misses the goal, else one per friction")
      .def_prop_ro(
          "holds", [](const SolveTry& t) { return t.result.holds(); }, "every run reached the goal")
      .def_prop_ro("plan_s", [](const SolveTry& t) { return t.result.plan_s; })
      .def_prop_ro("refine_s", [](const SolveTry& t) { return t.result.refine_s; })
      .def_prop_ro("simulate_s", [](const SolveTry& t) { return t.result.simulate_s; });
  nb::class_<SolveResult>(m, "SolveResult", "What became of all seeds.")
      .def_prop_ro("status", [](const SolveResult& r) { return r.result.status; })
      .def_prop_ro(
          "best",
          [](const SolveResult& r) {
            return SolveTry{r.task, r.result.best};
          },
          "the first that holds, else the best one")
      .def_prop_ro(
          "tries",
          [](const SolveResult& r) {
            std::vector<SolveTry> out;
            for (const auto& t : r.result.tries) out.push_back({r.task, t});
            return out;
          },
          "in the order of their seeds")
      .def_prop_ro("wall_s", [](const SolveResult& r) { return r.result.wall_s; })
      .def("__repr__", [](const SolveResult& r) {
        return fmt::format("<stiction.SolveResult: {}, seed {}, {} tries>", core::to_string(r.result.status), r.result.best.seed,
                           r.result.tries.size());
      });
  const tasks::SolveOptions standard;
  m.def("solve", &solve, "task"_a, nb::kw_only(), "options"_a = nb::none(), "seed"_a = nb::none(), "tries"_a = standard.tries,
        "friction"_a = standard.friction, "speed"_a = standard.speed, "threads"_a = 0, "timeout_s"_a = 120.0, "on_progress"_a = nb::none(),
        R"(Plans, refines, checks and simulates seeds until one reaches its goal in the second-order simulation.

  options: of the planner: PlannerOptions, or a dict of those that differ from the task's; None: the task's.
  seed: of the first try, the next ones count up; None: that of the options. tries: at most, >= 1.
  friction: the goal has to be reached with every coefficient of friction times each of these, >= 0.
  speed: of the runs, times the full timing that follows from the object and the motors (E.13), > 0; above 1 only pushes are faster.
  threads: 0 for all cores; the result does not depend on it. timeout_s: of all tries [s], > 0.
  on_progress: called with Progress; Ctrl-C and an error in it stop the run.

status: Solved: best.holds; MaxIterations: no try holds, or time used up; Cancelled. Raises InvalidInput.

    >>> found = st.solve(st.load_task("planar_pushing"), seed=0, tries=1, speed=20.0)
    >>> [(one.seed, one.status) for one in found.tries]
    [(0, Status.Solved)])");
  def_pickle<tasks::Finding, SolveRun, SolveTry, SolveResult>();
}

}  // namespace stiction::python
