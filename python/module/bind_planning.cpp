#include <fmt/format.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <atomic>
#include <exception>

#include "pickles.hpp"
#include "plan.hpp"
#include "planner_options.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/planning/sample_boxes.hpp"
#include "stiction/planning/thesis/packing.hpp"
#include "watcher.hpp"

namespace stiction::python {
namespace {

struct PlanResult {
  tasks::Task task;
  planning::PlannerOptions options;
  planning::PlanResult result;
  std::shared_ptr<Plan> plan;
};

using OnGrowth = std::optional<nb::typed<nb::callable, void(planning::Growth)>>;

/// What grows is told to the caller's function; an error in it is kept, and stops the search.
class GrowthTeller {
 public:
  explicit GrowthTeller(const OnGrowth& callback) : callback_(callback) {}

  planning::GrowthSink sink() {
    if (!callback_) return {};
    return [this](const planning::Growth& growth) { tell(growth); };
  }
  bool failed() const { return failed_.load(); }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  void tell(const planning::Growth& growth) {
    if (error_) return;
    const nb::gil_scoped_acquire locked;
    try {
      (*callback_)(growth);
    } catch (...) {
      error_ = std::current_exception();
      failed_.store(true);
    }
  }

  const OnGrowth& callback_;
  std::exception_ptr error_;
  std::atomic<bool> failed_{false};
};

std::unique_ptr<PlanResult> plan(const tasks::Task& task, const std::optional<Vector>& q_start, const std::optional<Vector>& u_start,
                                 const std::optional<OptionsLike>& options, std::optional<std::uint64_t> seed, std::optional<int> threads,
                                 double timeout_s, const Callback& on_progress, const OnGrowth& on_growth) {
  auto out =
      std::make_unique<PlanResult>(PlanResult{task, options ? options_of({task.model, task.options}, *options) : task.options, {}, {}});
  if (q_start) tasks::set_start(out->task, q_start->named("q_start"));
  const Eigen::VectorXd u = u_start ? u_start->named("u_start") : Eigen::VectorXd();
  if (seed) out->options.seed = *seed;
  if (threads) out->options.threads = *threads;
  out->options.validate(*task.model);
  Watcher watcher(on_progress);
  GrowthTeller teller(on_growth);
  core::RunControl control = watcher.control(timeout_s);
  control.abandoned = [&teller] { return teller.failed(); };
  {
    const nb::gil_scoped_release unlocked;
    (void)planning::plan_watched(out->task.problem, u, out->options, control, teller.sink(), out->result);  // the status is in the result
    tasks::Task planned = out->task;  // the plan is checked against what was asked for
    planned.options = out->options;
    planned.options_from_command_line |= options.has_value();
    planned.options.seed = task.options.seed;
    planned.options.threads = task.options.threads;
    out->plan = std::make_shared<Plan>(planned, out->options, out->result);
  }
  watcher.rethrow();
  teller.rethrow();
  return out;
}

Rows tree_errors(const PlanResult& r) {
  return rows(r.result.records, 2, [&r](const planning::NodeRecord& node) {
    const auto error = planning::goal_error(*r.task.model, node.q, r.task.problem.goal);
    return Eigen::RowVector2d(error.position, error.angle);
  });
}

Eigen::VectorXd packing_ratio(const PlanResult& r, double threshold, int samples, std::uint64_t seed) {
  const planning::PackingOptions options{
      .threshold = threshold, .gamma = r.options.thesis.value_or(planning::thesis::Settings{}).gamma, .samples = samples, .seed = seed};
  const auto boxes = r.options.sample_boxes.empty() ? planning::default_sample_boxes(r.task.problem) : r.options.sample_boxes;
  return planning::calc_packing_ratio(*r.task.model, boxes, r.result.records, options);
}

/// By the words of the Python package.
std::map<std::string, long> to_map(const planning::RegraspCounts& counts) {
  return {{"tried", counts.tried},     {"accepted", counts.accepted},         {"no_posture", counts.no_sample},
          {"no_path", counts.no_path}, {"object_moved", counts.object_moved}, {"failed_step", counts.failed_step}};
}

}  // namespace

void bind_planning(nb::module_& m) {
  nb::enum_<planning::SegmentKind>(m, "SegmentKind", "Kind of a segment of a plan.")
      .value("Settle", planning::SegmentKind::Settle, "objects come to rest from the given start, without overlaps (first segment only)")
      .value("Contact", planning::SegmentKind::Contact, "the robot pushes an object")
      .value("Regrasp", planning::SegmentKind::Regrasp, "the robot moves to new contacts while the object rests");
  nb::class_<core::Progress>(m, "Progress", "Argument of the function `on_progress` of long calls.")
      .def_ro("iteration", &core::Progress::iteration, "number of iterations so far")
      .def_ro("fraction", &core::Progress::fraction, "share of the budget that is used, in [0, 1]")
      .def_ro("best", &core::Progress::best, "smallest distance to the goal so far, or lowest cost")
      .def_ro("size", &core::Progress::size, "size of the search, such as the number of nodes")
      .def_ro("elapsed_s", &core::Progress::elapsed_s, "wall time since the start [s]");
  nb::class_<planning::Growth>(m, "Growth", "New nodes of a search tree since the last call of `on_growth`.")
      .def_ro("tree", &planning::Growth::tree,
              "index of the tree, from 0; trees grow side by side, and a tree that stalls is replaced by a new one")
      .def_ro("first", &planning::Growth::first, "index of the first new node in its tree")
      .def_ro("parents", &planning::Growth::parents, "index of each node's parent in the tree; -1 for the root (nodes)")
      .def_prop_ro(
          "q", [](const planning::Growth& g) { return rows(g.q); }, "configurations (nodes, n_q) [m, rad]")
      .def_prop_ro(
          "u", [](const planning::Growth& g) { return rows(g.u); }, "commands at the configurations (nodes, n_a) [m or rad]")
      .def_ro("best", &planning::Growth::best, "index of the node that is nearest the goal")
      .def_ro("best_ratio", &planning::Growth::best_ratio, "distance of this node from the goal, in tolerances");
  nb::class_<planning::NodeRecord>(m, "TreeNode", "A node of the search tree of Algorithm 2.")
      .def_ro("parent", &planning::NodeRecord::parent, "index of the parent; -1 for the root")
      .def_ro("edge", &planning::NodeRecord::edge, "kind of the edge from the parent")
      .def_ro("iteration", &planning::NodeRecord::iteration, "number of extensions when the node was added")
      .def_ro("q", &planning::NodeRecord::q, "configuration (n_q)")
      .def_ro("c_u", &planning::NodeRecord::c_u, "configuration of the objects after a smoothed step (n_qu)")
      .def_ro("B_u", &planning::NodeRecord::B_u, "rows of B for the objects (n_vu, n_a)");
  nb::class_<planning::RefusedMoves>(m, "RefusedMoves",
                                     "Regrasps that were tried from one node of a search tree, of which some were refused.")
      .def_ro("q", &planning::RefusedMoves::q, "configuration of the node (n_q)")
      .def_prop_ro(
          "counts", [](const planning::RefusedMoves& r) { return to_map(r.counts); }, "counts by cause, as in PlanResult.regrasps");
  bind_plan(m);
  nb::class_<PlanResult>(m, "PlanResult", "Result of plan(): the plan, its status, and statistics of the search.")
      .def_ro("plan", &PlanResult::plan, "best plan found, also if the status is not Solved")
      .def_prop_ro("status", [](const PlanResult& r) { return r.result.status; })
      .def_prop_ro(
          "reason", [](const PlanResult& r) { return r.result.reason; }, "why there is no solution, if the reason is not a used-up budget")
      .def_prop_ro(
          "options",
          [](const PlanResult& r) {
            return PlannerOptions{r.task.model, r.options};
          },
          "options with which the plan was made")
      .def_prop_ro("seed", [](const PlanResult& r) { return r.result.seed; })
      .def_prop_ro(
          "cost", [](const PlanResult& r) { return r.result.cost; },
          "cost of the plan: duration of its commands plus a cost for each regrasp [s]")
      .def_prop_ro(
          "start_penetration", [](const PlanResult& r) { return r.result.start_penetration; },
          "deepest penetration in the given start [m], >= 0")
      .def_prop_ro(
          "iterations", [](const PlanResult& r) { return r.result.iterations; }, "number of extensions of the trees")
      .def_prop_ro(
          "linearisations", [](const PlanResult& r) { return r.result.linearisations; }, "number of smoothed steps with the derivative B")
      .def_prop_ro(
          "nodes", [](const PlanResult& r) { return r.result.nodes; }, "number of nodes")
      .def_prop_ro(
          "steps", [](const PlanResult& r) { return r.result.steps; }, "number of exact steps")
      .def_prop_ro(
          "failed_steps", [](const PlanResult& r) { return r.result.failed_steps; }, "number of steps without a solution")
      .def_prop_ro(
          "profile",
          [](const PlanResult& r) {
            std::map<std::string, std::pair<double, long>> out;
            for (std::size_t i = 0; i < r.result.profile.entries.size(); ++i) {
              const auto& [processor_s, calls] = r.result.profile.entries[i];
              out.emplace(planning::kActivityNames[i], std::pair(processor_s, calls));
            }
            return out;
          },
          "processor time [s] and number of calls for each activity: {name: (time, calls)}; all 0 with the option `thesis`")
      .def_prop_ro(
          "regrasps", [](const PlanResult& r) { return to_map(r.result.regrasps); },
          "number of regrasps that were tried and accepted, and the number refused for each cause")
      .def_prop_ro(
          "refused", [](const PlanResult& r) { return r.result.refused; },
          "nodes from which regrasps were refused before a plan was found; empty with the option `thesis`")
      .def_prop_ro(
          "wall_s", [](const PlanResult& r) { return r.result.wall_s; }, "wall time of the search [s]")
      .def_prop_ro(
          "tree", [](const PlanResult& r) { return r.result.records; },
          "nodes of the search tree, the root first; only with the option `thesis`")
      .def_prop_ro("tree_errors", &tree_errors, "distance of each node of `tree` from the goal: position [m], angle [rad] (nodes, 2)")
      .def("packing_ratio", &packing_ratio, "threshold"_a = 3.0, "samples"_a = 1000, "seed"_a = 0,
           R"(Packing ratio (3.9) of the search tree after each of its nodes (nodes).

The packing ratio is the share of sampled configurations that lie within `threshold` of a node.

  threshold: η in (3.9), > 0.
  samples: number of configurations, drawn from the sample boxes of the task.
  seed: of these samples.

The regularisation γ is the value of the task.)")
      .def("__repr__", [](const PlanResult& r) {
        return fmt::format("<stiction.PlanResult: {}, {:.4g} m and {:.4g} rad from the goal>", core::to_string(r.result.status),
                           r.result.plan.error.position, r.result.plan.error.angle);
      });
  m.def("plan", &plan, "task"_a, nb::kw_only(), "q_start"_a = nb::none(), "u_start"_a = nb::none(), "options"_a = nb::none(),
        "seed"_a = nb::none(), "threads"_a = nb::none(), "timeout_s"_a = 20.0, "on_progress"_a = nb::none(), "on_growth"_a = nb::none(),
        R"(Searches for a motion of the robot that moves the object from the start to the goal of a task (Algorithms 2 and 3).

  task: Task with the model, the start and the goal.
  q_start: measured configuration from which to plan (n_q). Overlaps of bodies are removed first. None: the start of the task.
  u_start: measured commands at q_start (n_a) [m or rad]; they give the load of the joint springs at the start. None: each joint is
    commanded to its position in q_start.
  options: PlannerOptions, or a dict with the options to change. None: the options of the task.
  seed: of the random samples. None: the seed of the options.
  threads: 0: all cores. None: as in the options. The plan does not depend on this number.
  timeout_s: largest wall time [s], > 0.
  on_progress: function that is called with Progress. Ctrl-C or an error in the function stops the search. The return value False also
    stops the search, and plan() returns the best plan so far with the status Cancelled.
  on_growth: function that is called with Growth, the new nodes of a search tree. It does not change the plan.

Returns a PlanResult. Its status is Solved; MaxIterations: the time or the budget was used up, or see `reason`; Cancelled; or
NumericalFailure: the objects do not come to rest at the start. Raises InvalidInput.

    >>> task = st.load_task("planar_pushing")
    >>> result = st.plan(task, seed=0)
    >>> result.status, st.check_plan(result.plan).pass_
    (Status.Solved, True)
    >>> st.plan(task, seed=0, on_progress=lambda progress: False).status
    Status.Cancelled)");
  def_pickle<core::Progress, planning::Growth, planning::NodeRecord, planning::RefusedMoves, PlanResult>();
}

}  // namespace stiction::python
