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

/// Numbers with None among them. Without None they are a Vector.
struct OpenNumbers {
  std::vector<std::optional<double>> values;
};

}  // namespace
}  // namespace stiction::python

namespace nanobind::detail {

template <>
struct type_caster<stiction::python::OpenNumbers> {
  NB_TYPE_CASTER(stiction::python::OpenNumbers, const_name("collections.abc.Sequence[float | None]"))

  bool from_python(handle source, std::uint32_t, cleanup_list*) noexcept {
    const object items = steal(PySequence_Check(source.ptr()) ? PySequence_Tuple(source.ptr()) : nullptr);
    bool has_none = false;
    for (Py_ssize_t i = 0; items.is_valid() && i < PyTuple_GET_SIZE(items.ptr()); ++i) {
      const handle item = PyTuple_GET_ITEM(items.ptr(), i);
      has_none |= item.is_none();
      value.values.push_back(item.is_none() ? std::nullopt : std::optional(PyFloat_AsDouble(item.ptr())));
      if (PyErr_Occurred() != nullptr) break;
    }
    if (PyErr_Occurred() == nullptr) return has_none;
    PyErr_Clear();
    return false;
  }
};

}  // namespace nanobind::detail

namespace stiction::python {
namespace {

using tasks::Task;
using GoalLike = std::variant<OpenNumbers, Vector>;  // an array of None would be one of NaN

void set_goal(Task& task, const GoalLike& values) {
  if (const auto* numbers = std::get_if<Vector>(&values))
    return tasks::set_goal(task, {numbers->named("goal").data(), static_cast<std::size_t>(numbers->named("goal").size())});
  tasks::set_goal(task, std::get<OpenNumbers>(values).values);
}

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
Task with(const Task& task, const std::optional<Vector>& start, const std::optional<GoalLike>& goal,
          const std::optional<OptionsLike>& options) {
  Task out = task;
  if (start) tasks::set_start(out, start->named("start"));
  if (goal) set_goal(out, *goal);
  if (options) {
    out.options = options_of({task.model, task.options}, *options);
    out.options_from_command_line = true;
  }
  return out;
}

Rows goal_errors(const Task& task, const Matrix& q) {
  core::require_size("q.shape[1]", q.named("q").cols(), task.model->n_q());
  Rows out(q.named("q").rows(), 2);
  for (Eigen::Index i = 0; i < q.named("q").rows(); ++i) {
    const Eigen::VectorXd one = q.named("q").row(i);
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

}  // namespace

void bind_tasks(nb::module_& m) {
  bind_planner_options(m);
  nb::class_<planning::Goal>(m, "Goal", "Target pose of an object, with tolerances.")
      .def_ro("object", &planning::Goal::object, "index of the object")
      .def_ro("X_WG", &planning::Goal::X_WG, "target pose of the object in W")
      .def_prop_ro("open", &open_coordinates,
                   "for each velocity coordinate of the objects (n_vu), True if any value is accepted; empty: all coordinates count")
      .def_ro("tol_position", &planning::Goal::tol_position, "tolerance of the position [m]")
      .def_ro("tol_angle", &planning::Goal::tol_angle, "tolerance of the rotation angle [rad]");
  nb::class_<planning::GoalError>(m, "GoalError", "Distance of an object from its goal.")
      .def_ro("position", &planning::GoalError::position, "distance of the positions [m]")
      .def_ro("angle", &planning::GoalError::angle, "angle of the rotation between the orientations [rad]")
      .def("__repr__",
           [](const planning::GoalError& e) { return fmt::format("GoalError(position={:.4g}, angle={:.4g})", e.position, e.angle); });
  nb::class_<Task>(m, "Task", "A scene with robots and objects, a start configuration, a goal for an object, and planner options.")
      .def(
          "__init__",
          [](Task* self, const nb::dict& task, const std::optional<std::filesystem::path>& base) {
            new (self) Task(make_task(task, base));
          },
          "task"_a, nb::kw_only(), "base"_a = nb::none(),
          R"(Makes a task in memory, without a task file.

  task: dict with the keys of a task file (tasks/schema/task.schema.json). Its values may also be arrays, Pose objects, paths, and robots
    as text.
  base: folder to which paths in the dict are relative. None: the working folder.

Raises InvalidInput with the text "field: got …, expected …".

    >>> folder = st.load_task("planar_pushing").file.parent
    >>> task = st.Task({"base": "planar_pushing.yaml", "name": "wide", "tolerance": {"position": 0.05, "angle": 0.2}}, base=folder)
    >>> task.name, task.goal.tol_position
    ('wide', 0.05))")
      .def_ro("name", &Task::name, "name of the task")
      .def_ro("description", &Task::description, "one line about the task")
      .def_ro("file", &Task::file, "path of the task file; for a task made in memory, the folder to which its paths are relative")
      .def_ro("text", &Task::text, "text of a task made in memory, as in a task file; otherwise empty")
      .def_ro("model", &Task::model, "model of the scene")
      .def_prop_ro(
          "q_start", [](const Task& task) { return task.problem.q_start; }, "start configuration (n_q)")
      .def_prop_ro(
          "q_goal", [](const Task& task) { return task.problem.q_goal; },
          "configuration of the objects at the goal (n_qu); for a goal region, its point nearest to the start")
      .def_prop_ro(
          "goal", [](const Task& task) { return task.problem.goal; }, "target pose and tolerances")
      .def_prop_ro(
          "goal_objects", [](const Task& task) { return planning::goal_objects(*task.model, task.problem.goal); },
          "indices of the objects that the goal names, ascending; an object that carries another named object through a joint is left out")
      .def_prop_ro(
          "options",
          [](const Task& task) {
            return PlannerOptions{task.model, task.options};
          },
          "planner options of the task")
      .def_ro("scene_sha256", &Task::scene_sha256, "SHA-256 of the scene; plans store it")
      .def("with_", &with, nb::kw_only(), "start"_a = nb::none(), "goal"_a = nb::none(), "options"_a = nb::none(),
           R"(Returns a copy of the task with another start, goal or options. The task itself does not change.

  start: start configuration (n_q).
  goal: numbers as in set_goal().
  options: PlannerOptions, or a dict with the options to change.

None keeps the value of the task. Raises InvalidInput.

    >>> task = st.load_task("planar_pushing")
    >>> other = task.with_(goal=[0.6, 0.1, 0.0], options={"goal_bias": 0.3})
    >>> other.q_goal, other.options.goal_bias
    (array([0.6, 0.1, 0. ]), 0.3))")
      .def("goal_errors", &goal_errors, "q"_a,
           R"(Returns the distance of the object from the goal, or from the nearest pose of a goal region, at many configurations.

  q: configurations (N, n_q).

Returns position [m] and angle [rad] for each (N, 2).)")
      .def(
          "as_plan", [](const Task& task) { return std::make_shared<Plan>(task, task.options, tasks::make_unplanned(task)); },
          "Returns a plan that stays at the start, to show, export or compare the task without planning. Its status is MaxIterations, "
          "unless the "
          "start is at the goal.")
      .def(
          "follow",
          [](const Task& task, const Matrix& u, const std::optional<Vector>& u_start) {
            core::require_size("u.shape[1]", u.named("u").cols(), task.model->n_a());
            const Eigen::MatrixXd columns = u.named("u").transpose();
            const nb::gil_scoped_release unlocked;
            return std::make_shared<Plan>(task, task.options,
                                          tasks::make_commanded(task, columns, u_start ? u_start->named("u_start") : Eigen::VectorXd()));
          },
          "u"_a, nb::kw_only(), "u_start"_a = nb::none(),
          R"(Simulates commands from the start with the dynamics of the planner, and returns the motion as a plan with one push.

  u: commands (N, n_a) [m or rad].
  u_start: commands at the start (n_a) [m or rad]. None: each joint is commanded to its start position.

The status of the plan is Solved if it ends at the goal, and MaxIterations otherwise. If a step has no solution, the plan ends there and
has the status of that step. Raises InvalidInput.

    >>> task = st.load_task("planar_pushing")
    >>> plan = task.follow([[0.0, 0.0], [0.0, 0.1]])
    >>> plan.status, plan.u[-1]
    (Status.MaxIterations, array([0. , 0.1])))")
      .def("set_goal", &set_goal, "values"_a,
           R"(Replaces the goal of the task; the tolerances stay.

  values: for a free object x y z [m] roll pitch yaw [rad], for any other object its coordinates. Several objects follow one another. None
    in place of a number accepts any value of this coordinate.

Raises InvalidInput.)");
  m.def(
      "list_tasks", [] { return tasks::list_tasks(tasks::default_data_dirs()); },
      "Returns the names of the built-in tasks."
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
        "Returns the names of the keyframes of an MJCF file. The key `start` of a task accepts them. Raises InvalidInput."
        R"(

    >>> with open("keyed.xml", "w") as file:
    ...     _ = file.write("<mujoco><worldbody><body><joint name='j' type='slide'/><geom size='.1'/></body></worldbody>"
    ...                    "<keyframe><key name='home' qpos='.5'/></keyframe></mujoco>")
    >>> st.list_keyframes("keyed.xml")
    ['home'])");
  m.def("load_task", &load_task, "name_or_file"_a, nb::call_guard<nb::gil_scoped_release>(),
        R"(Loads a task: a scene with a start, a goal and planner options.

  name_or_file: name of a built-in task, or a task file. A str that ends in .yaml or .yml or contains a '/' is a file, and so is any
    os.PathLike.

Returns a Task. Raises InvalidInput with the text "FILE:LINE: field: got …, expected …".

    >>> task = st.load_task("allegro_cube")
    >>> task.model.n_a, task.model.object_names
    (16, ['cube']))");
  def_pickle<planning::Goal, planning::GoalError, Task, PlannerOptions>();
}

}  // namespace stiction::python
