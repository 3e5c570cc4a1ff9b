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
  if (q_start) tasks::set_start(out->task, q_start->value);
  const Eigen::VectorXd u = u_start ? u_start->value : Eigen::VectorXd();
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
  nb::enum_<planning::SegmentKind>(m, "SegmentKind", "What a piece of a plan does.")
      .value("Settle", planning::SegmentKind::Settle, "from the given start to rest on the constraints (first segment only)")
      .value("Contact", planning::SegmentKind::Contact, "the robot pushes")
      .value("Regrasp", planning::SegmentKind::Regrasp, "the robot moves to new contacts while the object rests");
  nb::class_<core::Progress>(m, "Progress", "What on_progress is told.")
      .def_ro("iteration", &core::Progress::iteration)
      .def_ro("fraction", &core::Progress::fraction, "of the budget used, in [0, 1]")
      .def_ro("best", &core::Progress::best, "distance to the goal so far; smaller is better")
      .def_ro("size", &core::Progress::size)
      .def_ro("elapsed_s", &core::Progress::elapsed_s);
  nb::class_<planning::Growth>(m, "Growth", "Nodes that a tree gained since it was last told of.")
      .def_ro("tree", &planning::Growth::tree, "of the run, from 0: trees grow side by side, and one that stalls makes room for the next")
      .def_ro("first", &planning::Growth::first, "number of the first of these nodes in their tree")
      .def_ro("parents", &planning::Growth::parents, "numbers of nodes in the tree, -1 of the root (nodes)")
      .def_prop_ro(
          "q", [](const planning::Growth& g) { return rows(g.q); }, "(nodes, n_q) [m, rad]")
      .def_prop_ro(
          "u", [](const planning::Growth& g) { return rows(g.u); }, "commands at q (nodes, n_a) [m or rad]")
      .def_ro("best", &planning::Growth::best, "node of the tree that is nearest the goal")
      .def_ro("best_ratio", &planning::Growth::best_ratio, "how far that one is, in tolerances");
  nb::class_<planning::NodeRecord>(m, "TreeNode", "A node of the search tree.")
      .def_ro("parent", &planning::NodeRecord::parent, "-1 of the root")
      .def_ro("edge", &planning::NodeRecord::edge, "that leads to it")
      .def_ro("iteration", &planning::NodeRecord::iteration, "extensions up to the end of its round")
      .def_ro("q", &planning::NodeRecord::q, "(n_q)")
      .def_ro("c_u", &planning::NodeRecord::c_u, "smoothed next configuration of the objects")
      .def_ro("B_u", &planning::NodeRecord::B_u, "their rows of B");
  nb::class_<planning::RefusedMoves>(m, "RefusedMoves", "Moves to new contacts from one node of a tree, of which some were refused.")
      .def_ro("q", &planning::RefusedMoves::q, "of the node (n_q)")
      .def_prop_ro(
          "counts", [](const planning::RefusedMoves& r) { return to_map(r.counts); }, "as in PlanResult.regrasps");
  bind_plan(m);
  nb::class_<PlanResult>(m, "PlanResult", "What came of a search.")
      .def_ro("plan", &PlanResult::plan, "the best path found, also where it is not Solved")
      .def_prop_ro("status", [](const PlanResult& r) { return r.result.status; })
      .def_prop_ro(
          "reason", [](const PlanResult& r) { return r.result.reason; },
          "why not Solved, where there is more to say than that the budget was used up")
      .def_prop_ro(
          "options",
          [](const PlanResult& r) {
            return PlannerOptions{r.task.model, r.options};
          },
          "that the plan was made with")
      .def_prop_ro("seed", [](const PlanResult& r) { return r.result.seed; })
      .def_prop_ro(
          "cost", [](const PlanResult& r) { return r.result.cost; }, "of the plan: time of its commands and a price for each regrasp [s]")
      .def_prop_ro(
          "start_penetration", [](const PlanResult& r) { return r.result.start_penetration; }, "deepest of the given start [m], >= 0")
      .def_prop_ro(
          "iterations", [](const PlanResult& r) { return r.result.iterations; }, "extensions of the tree")
      .def_prop_ro("linearisations", [](const PlanResult& r) { return r.result.linearisations; })
      .def_prop_ro("nodes", [](const PlanResult& r) { return r.result.nodes; })
      .def_prop_ro("steps", [](const PlanResult& r) { return r.result.steps; })
      .def_prop_ro("failed_steps", [](const PlanResult& r) { return r.result.failed_steps; })
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
          "activity -> (processor time [s], calls); all 0 with the options `thesis`")
      .def_prop_ro(
          "regrasps", [](const PlanResult& r) { return to_map(r.result.regrasps); },
          "how many moves to new contacts were tried and accepted, and what refused the others")
      .def_prop_ro(
          "refused", [](const PlanResult& r) { return r.result.refused; },
          "where moves to new contacts were refused until there was a plan, by nodes of the trees; none with the option `thesis`")
      .def_prop_ro("wall_s", [](const PlanResult& r) { return r.result.wall_s; })
      .def_prop_ro(
          "tree", [](const PlanResult& r) { return r.result.records; }, "its nodes, the root first, of a search with the option `thesis`")
      .def_prop_ro("tree_errors", &tree_errors, "distances of the nodes in `tree` from the goal [m], [rad] (nodes, 2)")
      .def("packing_ratio", &packing_ratio, "threshold"_a = 3.0, "samples"_a = 1000, "seed"_a = 0,
           "(3.9) after each node in `tree`, by the boxes and γ of the task (nodes)")
      .def("__repr__", [](const PlanResult& r) {
        return fmt::format("<stiction.PlanResult: {}, {:.4g} m and {:.4g} rad from the goal>", core::to_string(r.result.status),
                           r.result.plan.error.position, r.result.plan.error.angle);
      });
  m.def(
      "plan", &plan, "task"_a, nb::kw_only(), "q_start"_a = nb::none(), "u_start"_a = nb::none(), "options"_a = nb::none(),
      "seed"_a = nb::none(), "threads"_a = nb::none(), "timeout_s"_a = 20.0, "on_progress"_a = nb::none(), "on_growth"_a = nb::none(),
      "Plans a path of the object to the goal (Algorithms 2 and 3).\n\n"
      "q_start, u_start: where things are and what the joints are commanded to, as they were measured (n_q), (n_a): springs keep their "
      "strain, overlaps are moved apart; None: the start of the task, joints commanded where they are. "
      "options: PlannerOptions, or a dict of those that differ from the task's; None: the task's. seed, threads (0: all cores): None: "
      "those "
      "of the options; the plan does not depend on threads. timeout_s: [s] > 0. on_progress: called with Progress; Ctrl-C and an error "
      "in it "
      "stop the search, so does False, which keeps the best path so far (Cancelled). on_growth: called with Growth, the nodes that a tree "
      "gained; the plan is the same with it.\n\n"
      "status: Solved; MaxIterations (time or budget used up, or `reason`); Cancelled; NumericalFailure (the objects do not come to rest "
      "at "
      "the start). Raises InvalidInput."
      R"(

    >>> task = st.load_task("planar_pushing")
    >>> result = st.plan(task, seed=0)
    >>> result.status, st.check_plan(result.plan).pass_
    (Status.Solved, True)
    >>> st.plan(task, seed=0, on_progress=lambda progress: False).status
    Status.Cancelled)");
  def_pickle<core::Progress, planning::Growth, planning::NodeRecord, planning::RefusedMoves, PlanResult>();
}

}  // namespace stiction::python
