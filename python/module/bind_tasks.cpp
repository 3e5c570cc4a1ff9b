#include <fmt/format.h>

#include <fstream>

#include "pickles.hpp"
#include "plan.hpp"
#include "planner_options.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/import_scene.hpp"
#include "stiction/tasks/unplanned.hpp"
#include "yaml_text.hpp"

namespace stiction::python {
namespace {

using tasks::Task;

Task make_task(const nb::dict& task, const std::optional<std::filesystem::path>& base) {
  const std::string text = yaml_text(task);
  const std::filesystem::path folder = folder_of(base);
  const nb::gil_scoped_release unlocked;
  return tasks::parse_task(text, folder);
}

/// @param task  a name or a file; what is no str is a file
Task load_task(const std::variant<std::string, std::filesystem::path>& task) {
  const auto* file = std::get_if<std::filesystem::path>(&task);
  Task out = tasks::load_task(file != nullptr ? std::filesystem::absolute(*file).string() : std::get<std::string>(task));
  const nb::gil_scoped_acquire gil;
  warn_of_options(out.notes);
  return out;
}

/// @param out  the task file to write; nullopt: a task in memory
Task import_scene(const std::filesystem::path& file, const std::optional<std::filesystem::path>& out, const std::string& object) {
  const std::filesystem::path folder = out ? std::filesystem::absolute(*out).parent_path() : std::filesystem::current_path();
  const std::string text = tasks::import_scene(file, folder, object);
  if (!out) return tasks::parse_task(text, folder);
  std::ofstream to(*out, std::ios::binary);
  to << text;
  to.close();
  if (!to) core::throw_invalid("out", fmt::format("'{}', which cannot be written", out->string()), "a file in a folder that is there");
  return tasks::load_task(std::filesystem::absolute(*out).string());
}

/// The task with other values, as a task of its own.
Task with(const Task& task, const std::optional<Vector>& start, const std::optional<Vector>& goal,
          const std::optional<OptionsLike>& options) {
  Task out = task;
  if (start) tasks::set_start(out, start->value);
  if (goal) tasks::set_goal(out, {goal->value.data(), static_cast<std::size_t>(goal->value.size())});
  if (options) {
    out.options = options_of({task.model, task.options}, *options);
    out.options_from_command_line = true;
  }
  return out;
}

Rows goal_errors(const Task& task, const Matrix& q) {
  core::require_size("q.shape[1]", q.value.cols(), task.model->n_q());
  Rows out(q.value.rows(), 2);
  for (Eigen::Index i = 0; i < q.value.rows(); ++i) {
    const Eigen::VectorXd one = q.value.row(i);
    world::require_configuration(*task.model, fmt::format("q[{}]", i), one);
    const planning::GoalError error = planning::goal_error(*task.model, one, task.problem.goal);
    out.row(i) << error.position, error.angle;
  }
  return out;
}

std::vector<bool> open_coordinates(const planning::Goal& goal) {
  std::vector<bool> out;
  if (!goal.region) return out;
  for (Eigen::Index i = 0; i < goal.region->lower.size(); ++i)
    out.push_back(std::isinf(goal.region->lower[i]) && std::isinf(goal.region->upper[i]));
  return out;
}

using GoalLike = std::variant<std::vector<std::optional<double>>, Vector>;  // an array of None would be one of NaN

void set_goal(Task& task, const GoalLike& values) {
  if (const auto* numbers = std::get_if<Vector>(&values))
    return tasks::set_goal(task, {numbers->value.data(), static_cast<std::size_t>(numbers->value.size())});
  tasks::set_goal(task, std::get<std::vector<std::optional<double>>>(values));
}

}  // namespace

void bind_tasks(nb::module_& m) {
  bind_planner_options(m);
  nb::class_<planning::Goal>(m, "Goal", "Where an object is to be, and how near is near enough.")
      .def_ro("object", &planning::Goal::object, "index of the object")
      .def_ro("X_WG", &planning::Goal::X_WG)
      .def_prop_ro("open", &open_coordinates,
                   "of the objects' coordinates, in the order of their velocities (n_vu), which may have any value; empty: none")
      .def_ro("tol_position", &planning::Goal::tol_position, "[m]")
      .def_ro("tol_angle", &planning::Goal::tol_angle, "[rad]");
  nb::class_<planning::GoalError>(m, "GoalError", "How far an object is from its goal.")
      .def_ro("position", &planning::GoalError::position, "[m]")
      .def_ro("angle", &planning::GoalError::angle, "[rad]")
      .def("__repr__",
           [](const planning::GoalError& e) { return fmt::format("GoalError(position={:.4g}, angle={:.4g})", e.position, e.angle); });
  nb::class_<Task>(m, "Task", "A scene, a start, a goal and how to plan.")
      .def(
          "__init__",
          [](Task* self, const nb::dict& task, const std::optional<std::filesystem::path>& base) {
            new (self) Task(make_task(task, base));
          },
          "task"_a, nb::kw_only(), "base"_a = nb::none(),
          "A task made in memory: a dict with the keys of a task file (tasks/schema/task.schema.json). Arrays, poses, paths and robots as "
          "text "
          "may stand in it. base: the folder that paths in it are relative to; None: the working folder. Raises InvalidInput: \"field: "
          "got …, expected "
          "…\"."
          R"(

    >>> folder = st.load_task("planar_pushing").file.parent
    >>> task = st.Task({"base": "planar_pushing.yaml", "name": "wide", "tolerance": {"position": 0.05, "angle": 0.2}}, base=folder)
    >>> task.name, task.goal.tol_position
    ('wide', 0.05))")
      .def_ro("name", &Task::name)
      .def_ro("description", &Task::description)
      .def_ro("file", &Task::file, "of a task made in memory the folder that its paths are relative to")
      .def_ro("text", &Task::text, "of a task made in memory, as in a file; else empty")
      .def_ro("model", &Task::model)
      .def_prop_ro(
          "q_start", [](const Task& task) { return task.problem.q_start; }, "(n_q)")
      .def_prop_ro(
          "q_goal", [](const Task& task) { return task.problem.q_goal; },
          "of the objects at the goal; of a goal region what is nearest to the start (n_qu)")
      .def_prop_ro("goal", [](const Task& task) { return task.problem.goal; })
      .def_prop_ro(
          "goal_objects", [](const Task& task) { return planning::goal_objects(*task.model, task.problem.goal); },
          "indices of the objects that the goal names, ascending; without those that another of them hangs on")
      .def_prop_ro(
          "options",
          [](const Task& task) {
            return PlannerOptions{task.model, task.options};
          },
          "of its section `planner`")
      .def_ro("scene_sha256", &Task::scene_sha256)
      .def("with_", &with, nb::kw_only(), "start"_a = nb::none(), "goal"_a = nb::none(), "options"_a = nb::none(),
           "The task with another start (n_q), goal (as in set_goal) or options (PlannerOptions, or a dict of those that differ); this one "
           "stays as it is. Raises InvalidInput."
           R"(

    >>> task = st.load_task("planar_pushing")
    >>> other = task.with_(goal=[0.6, 0.1, 0.0], options={"goal_bias": 0.3})
    >>> other.q_goal, other.options.goal_bias
    (array([0.6, 0.1, 0. ]), 0.3))")
      .def("goal_errors", &goal_errors, "q"_a,
           "How far the object is from the goal, or from the nearest pose of the goal region, at many configurations (N, n_q): position "
           "[m] and "
           "angle [rad], (N, 2).")
      .def(
          "as_plan", [](const Task& task) { return std::make_shared<Plan>(task, task.options, tasks::make_unplanned(task)); },
          "A plan that stays at the start, to be shown, exported or compared: MaxIterations, unless the start is at the goal.")
      .def(
          "follow",
          [](const Task& task, const Matrix& u, const std::optional<Vector>& u_start) {
            core::require_size("u.shape[1]", u.value.cols(), task.model->n_a());
            const Eigen::MatrixXd columns = u.value.transpose();
            const nb::gil_scoped_release unlocked;
            return std::make_shared<Plan>(task, task.options,
                                          tasks::make_commanded(task, columns, u_start ? u_start->value : Eigen::VectorXd()));
          },
          "u"_a, nb::kw_only(), "u_start"_a = nb::none(),
          "The motion that commands (N, n_a) [m or rad] make from the start, with the dynamics of the planner, as a plan of one push. "
          "Solved "
          "where it ends at the goal, MaxIterations where not; else the status of the step that has no solution, where the plan ends. "
          "Raises "
          "InvalidInput."
          R"(

    >>> task = st.load_task("planar_pushing")
    >>> plan = task.follow([[0.0, 0.0], [0.0, 0.1]])
    >>> plan.status, plan.u[-1]
    (Status.MaxIterations, array([0. , 0.1])))")
      .def("set_goal", &set_goal, "values"_a,
           "x y z [m] roll pitch yaw [rad] of a free object, the coordinates of any other; of several objects one after the other. None: "
           "any value. Raises InvalidInput.");
  m.def(
      "list_tasks", [] { return tasks::list_tasks(tasks::default_data_dirs()); },
      "Names of the built-in tasks."
      R"(

    >>> "allegro_cube" in st.list_tasks()
    True)");
  m.def("_import_scene", &import_scene, "file"_a, nb::kw_only(), "out"_a = nb::none(), "object"_a = "",
        nb::call_guard<nb::gil_scoped_release>(), "Of scenes.py: an MJCF or URDF file.");
  m.def(
      "_parse_task",
      [](const std::string& text, const std::optional<std::filesystem::path>& base) { return tasks::parse_task(text, folder_of(base)); },
      "text"_a, "base"_a = nb::none(), nb::call_guard<nb::gil_scoped_release>(), "Of scenes.py: the text of a task file.");
  m.def("list_keyframes", &tasks::list_keyframes, "file"_a, nb::call_guard<nb::gil_scoped_release>(),
        "Names of the keyframes of an MJCF file, as a start of a task takes them. Raises InvalidInput."
        R"(

    >>> with open("keyed.xml", "w") as file:
    ...     _ = file.write("<mujoco><worldbody><body><joint name='j' type='slide'/><geom size='.1'/></body></worldbody>"
    ...                    "<keyframe><key name='home' qpos='.5'/></keyframe></mujoco>")
    >>> st.list_keyframes("keyed.xml")
    ['home'])");
  m.def("load_task", &load_task, "name_or_file"_a, nb::call_guard<nb::gil_scoped_release>(),
        "A built-in task by its name, or a file: a str that ends in .yaml or .yml or has a '/', or any os.PathLike. Raises InvalidInput: "
        "\"FILE:LINE: field: got …, expected …\"."
        R"(

    >>> task = st.load_task("allegro_cube")
    >>> task.model.n_a, task.model.object_names
    (16, ['cube']))");
  def_pickle<planning::Goal, planning::GoalError, Task, PlannerOptions>();
}

}  // namespace stiction::python
