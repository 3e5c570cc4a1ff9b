#include <fmt/format.h>
#include <nanobind/stl/unique_ptr.h>

#include "stiction/planning/packing.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/tasks/optimize_options.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/task.hpp"
#include "watcher.hpp"

namespace stiction::python {
namespace {

struct PlanResult {
  tasks::Task task;
  planning::PlannerOptions options;
  planning::PlanResult result;
};

std::unique_ptr<PlanResult> plan(const tasks::Task& task, std::optional<std::uint64_t> seed, std::optional<std::string_view> scheme,
                                 double timeout_s, int threads, const Callback& on_progress) {
  auto out = std::make_unique<PlanResult>(PlanResult{task, task.options, {}});
  if (seed) out->options.seed = *seed;
  if (scheme) out->options.scheme = tasks::parse_scheme("scheme", *scheme);
  out->options.threads = threads;
  Watcher watcher(on_progress);
  const core::RunControl control = watcher.control(timeout_s);
  {
    const nb::gil_scoped_release unlocked;
    (void)planning::plan(task.problem, out->options, control, out->result);
  }
  watcher.rethrow();
  return out;
}

/// All knots of a plan, the start first, as columns.
template <class Get>
Eigen::MatrixXd path(const planning::Plan& plan, const Eigen::VectorXd& start, Get get) {
  Eigen::Index columns = 1;
  for (const auto& segment : plan.segments) columns += static_cast<Eigen::Index>(segment.knots.size());
  Eigen::MatrixXd out(start.size(), columns);
  out.col(0) = start;
  Eigen::Index at = 1;
  for (const auto& segment : plan.segments) {
    for (const auto& knot : segment.knots) out.col(at++) = get(knot);
  }
  return out;
}

std::string_view edge_name(planning::SegmentKind kind) {
  switch (kind) {
    case planning::SegmentKind::Settle:
      return "settle";
    case planning::SegmentKind::Contact:
      return "contact";
    case planning::SegmentKind::Regrasp:
      break;
  }
  return "regrasp";
}

Eigen::MatrixXd tree_errors(const PlanResult& r) {
  Eigen::MatrixXd out(2, static_cast<Eigen::Index>(r.result.records.size()));
  for (std::size_t i = 0; i < r.result.records.size(); ++i) {
    const auto error = planning::goal_error(*r.task.model, r.result.records[i].q, r.task.problem.goal);
    out.col(static_cast<Eigen::Index>(i)) << error.position, error.angle;
  }
  return out;
}

Eigen::VectorXd packing_ratio(const PlanResult& r, double threshold, int samples, std::uint64_t seed) {
  const planning::PackingOptions options{.threshold = threshold, .gamma = r.options.gamma, .samples = samples, .seed = seed};
  return planning::calc_packing_ratio(*r.task.model, r.options.sample_boxes, r.result.records, options);
}

void bind_task(nb::module_& m) {
  using tasks::Task;
  nb::class_<planning::Goal>(m, "Goal")
      .def_ro("object", &planning::Goal::object, "index of the object")
      .def_ro("X_WG", &planning::Goal::X_WG)
      .def_ro("tol_position", &planning::Goal::tol_position, "[m]")
      .def_ro("tol_angle", &planning::Goal::tol_angle, "[rad]");
  nb::class_<planning::GoalError>(m, "GoalError")
      .def_ro("position", &planning::GoalError::position, "[m]")
      .def_ro("angle", &planning::GoalError::angle, "[rad]");
  nb::class_<Task>(m, "Task", "A scene, a start, a goal and how to plan.")
      .def_ro("name", &Task::name)
      .def_ro("description", &Task::description)
      .def_ro("file", &Task::file)
      .def_ro("model", &Task::model)
      .def_prop_ro(
          "q_start", [](const Task& task) { return task.problem.q_start; }, "(n_q)")
      .def_prop_ro("goal", [](const Task& task) { return task.problem.goal; })
      .def_ro("scene_sha256", &Task::scene_sha256)
      .def(
          "set_goal",
          [](Task& task, const Vector& values) {
            tasks::set_goal(task, {values.value.data(), static_cast<std::size_t>(values.value.size())});
          },
          "values"_a, "x y z [m] roll pitch yaw [rad] of a free object, the coordinates of any other");
  m.def(
      "list_tasks", [] { return tasks::list_tasks(tasks::default_data_dirs()); }, "Names of the built-in tasks.");
  m.def(
      "load_task", [](const std::string& task) { return tasks::load_task(task); }, "name_or_file"_a,
      nb::call_guard<nb::gil_scoped_release>(), "A built-in task by its name, or a file.");
}

}  // namespace

void bind_planning(nb::module_& m) {
  bind_task(m);
  nb::class_<core::Progress>(m, "Progress")
      .def_ro("iteration", &core::Progress::iteration)
      .def_ro("fraction", &core::Progress::fraction, "of the budget used, in [0, 1]")
      .def_ro("best", &core::Progress::best, "distance to the goal so far; smaller is better")
      .def_ro("size", &core::Progress::size)
      .def_ro("elapsed_s", &core::Progress::elapsed_s);
  nb::class_<planning::NodeRecord>(m, "TreeNode")
      .def_ro("parent", &planning::NodeRecord::parent, "-1 of the root")
      .def_prop_ro(
          "edge", [](const planning::NodeRecord& n) { return edge_name(n.edge); }, "that leads to it: settle, contact, regrasp")
      .def_ro("iteration", &planning::NodeRecord::iteration, "extensions up to the end of its round")
      .def_ro("q", &planning::NodeRecord::q, "(n_q)")
      .def_ro("c_u", &planning::NodeRecord::c_u, "smoothed next configuration of the objects")
      .def_ro("B_u", &planning::NodeRecord::B_u, "their rows of B");
  nb::class_<PlanResult>(m, "PlanResult")
      .def_prop_ro("status", [](const PlanResult& r) { return r.result.status; })
      .def_prop_ro("seed", [](const PlanResult& r) { return r.result.seed; })
      .def_prop_ro(
          "error", [](const PlanResult& r) { return r.result.plan.error; }, "of the object at the last knot")
      .def_prop_ro(
          "q", [](const PlanResult& r) { return path(r.result.plan, r.result.plan.q_start, [](const auto& k) { return k.q; }); },
          "configurations of the best path, the start first (n_q, knots + 1)")
      .def_prop_ro(
          "u", [](const PlanResult& r) { return path(r.result.plan, r.result.plan.u_start, [](const auto& k) { return k.u; }); },
          "commands (n_a, knots + 1)")
      .def_prop_ro("iterations", [](const PlanResult& r) { return r.result.iterations; })
      .def_prop_ro("nodes", [](const PlanResult& r) { return r.result.nodes; })
      .def_prop_ro("steps", [](const PlanResult& r) { return r.result.steps; })
      .def_prop_ro("failed_steps", [](const PlanResult& r) { return r.result.failed_steps; })
      .def_prop_ro("wall_s", [](const PlanResult& r) { return r.result.wall_s; })
      .def_prop_ro(
          "tree", [](const PlanResult& r) { return r.result.records; }, "its nodes, the root first, with `record_tree` in the task")
      .def_prop_ro("tree_errors", &tree_errors, "distances of the nodes in `tree` from the goal [m], [rad] (2, nodes)")
      .def("packing_ratio", &packing_ratio, "threshold"_a = 3.0, "samples"_a = 1000, "seed"_a = 0,
           "(3.9) after each node in `tree`, by the boxes and γ of the task (nodes)")
      .def(
          "write",
          [](const PlanResult& r, const std::filesystem::path& file) {
            tasks::write_plan(tasks::make_plan_file(r.task, r.options, r.result, file), file);
          },
          "file"_a, "writes the plan file that `stiction check` and `stiction view` read")
      .def("__repr__", [](const PlanResult& r) {
        return fmt::format("<stiction.PlanResult: {}, {:.4g} m and {:.4g} rad from the goal>", core::to_string(r.result.status),
                           r.result.plan.error.position, r.result.plan.error.angle);
      });
  m.def("plan", &plan, "task"_a, nb::kw_only(), "seed"_a = nb::none(), "scheme"_a = nb::none(), "timeout_s"_a = 20.0, "threads"_a = 0,
        "on_progress"_a = nb::none(), "Plans a path of the object to the goal. Ctrl-C and an error in on_progress stop it.");
}

}  // namespace stiction::python
