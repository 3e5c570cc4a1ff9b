#include <fmt/format.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>

#include "pickles.hpp"
#include "plan.hpp"
#include "planner_options.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/execution/open_loop/trajectory.hpp"
#include "stiction/planning/refine.hpp"
#include "stiction/tasks/check.hpp"
#include "stiction/tasks/plan_slice.hpp"
#include "watcher.hpp"
#include "yaml_text.hpp"

namespace stiction::python {

Plan::Plan(const tasks::Task& of, const planning::PlannerOptions& options, const planning::PlanResult& result)
    : task(of), file(tasks::make_plan_file(of, options, result, of.file.parent_path() / "plan.json")) {}

Plan::Plan(tasks::PlanFile of, const std::filesystem::path& path)
    : task(tasks::load_task_of_plan(of, path, tasks::default_data_dirs())), file(std::move(of)) {
  if (file.start_from_command_line) tasks::set_start(task, file.q_start);
  task.goal_from_command_line = file.goal_from_command_line;
  task.options_from_command_line = file.options_from_command_line;
}

tasks::PlanFile Plan::at(const std::filesystem::path& path) const {
  tasks::PlanFile out = file;
  out.task_file = tasks::spell_task_file(task, path);
  return out;
}

namespace {

using planning::RefineResult;
using tasks::CheckItem;
using tasks::CheckReport;

std::shared_ptr<Plan> read_plan(const std::filesystem::path& file) { return std::make_shared<Plan>(tasks::read_plan(file), file); }

/// @param folder  that the path of the task in the text is relative to
std::shared_ptr<Plan> parse_plan(const std::string& text, const std::optional<std::filesystem::path>& folder) {
  const std::filesystem::path file = folder_of(folder) / "plan.json";
  try {
    return std::make_shared<Plan>(tasks::parse_plan(text, file), file);
  } catch (const core::InvalidInput& error) {  // there is no such file: what is wrong stands in the text
    std::string message = error.what();
    const std::string name = file.string();
    for (std::size_t at = message.find(name); at != std::string::npos; at = message.find(name, at))
      message.replace(at, name.size(), "text");
    throw core::InvalidInput(message);
  }
}

std::string to_text(const Plan& plan, const std::optional<std::filesystem::path>& folder) {
  return tasks::to_text(plan.at(folder_of(folder) / "plan.json"));
}

/// All knots, the start first.
template <class Get>
Rows path(const tasks::PlanFile& file, const Eigen::VectorXd& start, Get get) {
  std::vector<const Eigen::VectorXd*> knots = {&start};
  for (const auto& segment : file.segments) {
    for (const auto& knot : segment.knots) knots.push_back(&get(knot));
  }
  return rows(knots, start.size(), [](const auto* knot) { return knot->transpose(); });
}

template <class Get>
Rows knots_of(const tasks::StoredSegment& segment, Get get) {
  return rows(segment.knots, segment.knots.empty() ? 0 : get(segment.knots[0]).size(),
              [&get](const auto& knot) { return get(knot).transpose(); });
}

const auto kQ = [](const tasks::StoredKnot& knot) -> const Eigen::VectorXd& { return knot.q; };
const auto kU = [](const tasks::StoredKnot& knot) -> const Eigen::VectorXd& { return knot.u; };

/// A contact of a knot, with the names of what touches.
struct PlanContact {
  std::string a, b;
  tasks::StoredContact contact;
};

/// Of all knots, the start first, of which no contacts are known.
std::vector<std::vector<PlanContact>> contacts_of(const Plan& plan) {
  const auto name = [&plan](int geometry) { return plan.file.geometries[static_cast<std::size_t>(geometry)].name; };
  std::vector<std::vector<PlanContact>> out(1);
  for (const auto& segment : plan.file.segments) {
    for (const auto& knot : segment.knots) {
      auto& contacts = out.emplace_back();
      for (const auto& c : knot.contacts) contacts.push_back({name(c.a), name(c.b), c});
    }
  }
  return out;
}

/// Some segments as a plan. @throws nb::value_error: a stride
std::shared_ptr<Plan> slice(const Plan& plan, const nb::slice& which) {
  const auto [first, last, step, count] = which.compute(plan.file.segments.size());
  if (step != 1) core::throw_invalid("slice", fmt::format("a step of {}", step), "neighbouring segments, a step of 1");
  auto out = std::make_shared<Plan>(plan);
  out->file = tasks::slice(plan.task, plan.file, static_cast<std::size_t>(first), static_cast<std::size_t>(first) + count);
  if (out->file.start_from_command_line) tasks::set_start(out->task, out->file.q_start);
  return out;
}

tasks::StoredSegment segment(const Plan& plan, Py_ssize_t i) {
  const auto count = static_cast<Py_ssize_t>(plan.file.segments.size());
  if (i < -count || i >= count) throw nb::index_error(fmt::format("{} of {} segments", i, count).c_str());
  return plan.file.segments[static_cast<std::size_t>(i < 0 ? i + count : i)];
}

struct Refined {
  RefineResult result;
  std::shared_ptr<Plan> plan;
};

std::unique_ptr<Refined> refine(const Plan& plan, const std::optional<OptionsLike>& given, std::optional<int> threads, double timeout_s,
                                const Callback& on_progress) {
  if (plan.file.status != core::Status::Solved)
    core::throw_invalid("plan.status", std::string(core::to_string(plan.file.status)), "Solved: a plan that reaches its goal");
  planning::PlannerOptions options = tasks::options_of_plan(plan.model(), plan.file, "plan");
  if (given) options = options_of({plan.task.model, options}, *given);
  if (threads) options.threads = *threads;
  auto out = std::make_unique<Refined>();
  Watcher watcher(on_progress);
  const core::RunControl control = watcher.control(timeout_s);
  {
    const nb::gil_scoped_release unlocked;
    planning::PlanResult refined = tasks::to_result(plan.model(), plan.file);  // the statistics stay those of the search
    (void)planning::refine(plan.task.model, refined.plan, options, {}, control, out->result);
    refined.plan = out->result.plan;
    refined.wall_s += out->result.wall_s;
    tasks::Task of = plan.task;
    of.options_from_command_line |= given.has_value();
    out->plan = std::make_shared<Plan>(of, options, refined);
  }
  watcher.rethrow();
  return out;
}

std::unique_ptr<CheckReport> check_plan(const Plan& plan) {
  auto out = std::make_unique<CheckReport>();
  Interrupt interrupt;
  {
    const nb::gil_scoped_release unlocked;
    (void)tasks::check_plan(plan.task, plan.file, {}, interrupt.control({}), *out);
  }
  interrupt.rethrow();
  return out;
}

execution::Trajectory make_trajectory(const Plan& plan, double speed, double pause) {
  return execution::make_trajectory(plan.model(), tasks::to_plan(plan.model(), plan.file), speed, pause);
}

void bind_check(nb::module_& m) {
  nb::class_<CheckItem>(m, "CheckItem", "One result of check_plan(): a value and its limit.")
      .def_ro("name", &CheckItem::name, "name of the item")
      .def_ro("value", &CheckItem::value, "measured value, in `unit`")
      .def_ro("limit", &CheckItem::limit, "largest value that passes; None: the value is reported but not judged")
      .def_ro("unit", &CheckItem::unit, "unit of value and limit, such as m; empty: no unit")
      .def_ro("pass_", &CheckItem::pass, "True: the value is within the limit")
      .def_ro("where", &CheckItem::where, "body, joint or knot with the worst value; may be empty")
      .def("__repr__", [](const CheckItem& c) {
        return fmt::format("<stiction.CheckItem: {} {:.4g} {}, {}>", c.name, c.value, c.unit, c.pass ? "passed" : "failed");
      });
  nb::class_<CheckReport>(m, "CheckReport", "Result of check_plan(): the verdict and the items behind it.")
      .def_ro("pass_", &CheckReport::pass, "True: the plan passed every check")
      .def_ro("status", &CheckReport::status, "Solved: all checks were made")
      .def_ro("items", &CheckReport::items, "results of the single checks")
      .def("at", &CheckReport::at, "name"_a, nb::rv_policy::copy, "Returns the item of this name. Raises InvalidInput: no such item.")
      .def_ro("knots", &CheckReport::knots, "number of knots that were checked")
      .def_ro("steps", &CheckReport::steps, "number of steps that were simulated")
      .def_ro("threshold_N", &CheckReport::threshold_N, "contacts with a smaller force than this are ignored [N]")
      .def_ro("wall_s", &CheckReport::wall_s, "wall time [s]")
      .def("__repr__", [](const CheckReport& r) {
        std::string failed;
        for (const auto& item : r.items) {
          if (!item.pass) failed += (failed.empty() ? ": " : ", ") + item.name;
        }
        return fmt::format("<stiction.CheckReport: {}{}>", r.pass ? "passed" : "failed", failed);
      });
  m.def("check_plan", &check_plan, "plan"_a,
        R"(Checks a plan independently of the planner: does it reach the goal, and are its forces physically possible?

The check simulates the plan again with the exact dynamics, at half of the plan's sub-step. It compares the numbers stored in the plan with
this simulation and with the task, and shares no planning code with the planner.

Returns a CheckReport: its attribute pass_ is the verdict, and its items give the single checks.

    >>> report = st.check_plan(st.plan(st.load_task("planar_pushing"), seed=0).plan)
    >>> report.pass_, report.at("goal_position").unit
    (True, 'm'))");
}

void bind_refine(nb::module_& m) {
  nb::class_<Refined>(m, "RefineResult", "Result of refine(): the refined plan and what changed.")
      .def_prop_ro(
          "status", [](const Refined& r) { return r.result.status; }, "see refine()")
      .def_ro("plan", &Refined::plan, "the refined plan, or the given plan if it could not be refined")
      .def_prop_ro(
          "variant", [](const Refined& r) { return r.result.variant; }, "kind of the result: refined or unchanged")
      .def_prop_ro(
          "pushes", [](const Refined& r) { return std::pair(r.result.pushes_before, r.result.pushes); }, "number of pushes (before, after)")
      .def_prop_ro(
          "regrasps", [](const Refined& r) { return std::pair(r.result.regrasps_before, r.result.regrasps); },
          "number of regrasps (before, after)")
      .def_prop_ro(
          "least_clearance", [](const Refined& r) { return r.result.least_clearance; },
          "smallest clearance of the regrasps that were planned again [m]; 0: there was no such regrasp")
      .def_prop_ro(
          "rest_planned_anew", [](const Refined& r) { return r.result.rest_planned_anew; },
          "number of searches for the rest of the plan after a push that missed its end in small steps")
      .def_prop_ro(
          "steps", [](const Refined& r) { return r.result.steps; }, "number of steps that were simulated")
      .def_prop_ro(
          "failed_steps", [](const Refined& r) { return r.result.failed_steps; }, "number of steps without a solution")
      .def_prop_ro(
          "wall_s", [](const Refined& r) { return r.result.wall_s; }, "wall time [s]")
      .def("__repr__", [](const Refined& r) {
        return fmt::format("<stiction.RefineResult: {}, {}>", core::to_string(r.result.status), r.result.variant);
      });
  m.def("refine", &refine, "plan"_a, nb::kw_only(), "options"_a = nb::none(), "threads"_a = nb::none(), "timeout_s"_a = 20.0,
        "on_progress"_a = nb::none(),
        R"(Shortens a plan and gives its regrasps more clearance (docs/theory/refinement.md). Use it before a plan is executed.

Refinement drops pushes that move nothing, follows the others in small time steps, and plans the motions between them again.

  plan: a plan with the status Solved.
  options: PlannerOptions, or a dict with the options to change. None: the options with which the plan was made.
  threads: 0: all cores. None: as in the options. The result does not depend on this number.
  timeout_s: largest wall time [s], > 0.
  on_progress: function that is called with Progress. Ctrl-C, an error in the function or the return value False stop the refinement.

Returns a RefineResult. Its status is Solved; MaxIterations (time used up) or Cancelled: its plan is the given plan; NumericalFailure: the given plan does not reach its goal. Raises InvalidInput.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> refined = st.refine(plan)
    >>> refined.status, st.check_plan(refined.plan).pass_
    (Status.Solved, True))");
}

void bind_trajectory(nb::module_& m) {
  using execution::Trajectory;
  nb::class_<Trajectory>(m, "Trajectory",
                         "A plan with times: commands, linear between knots, and the configurations that the plan predicts.")
      .def_ro("times", &Trajectory::times, "times of the knots, from 0 [s] (knots)")
      .def_prop_ro(
          "u", [](const Trajectory& t) { return rows(t.u); }, "commands (knots, n_a) [m or rad]")
      .def_prop_ro(
          "q", [](const Trajectory& t) { return rows(t.q); }, "predicted configurations (knots, n_q)")
      .def_ro("segments", &Trajectory::segments, "index of the plan's segment that leads to each knot (knots)")
      .def_ro("knots", &Trajectory::knots, "row of Plan.q for each knot: the end of the sub-step that the knot belongs to (knots)")
      .def_ro("speed", &Trajectory::speed, "factor on the full speed of make_trajectory()")
      .def_prop_ro("duration", &Trajectory::duration, "time of the last knot [s]");
  m.attr("OPEN_LOOP_SPEED") = execution::kOpenLoopSpeed;
  m.def("make_trajectory", &make_trajectory, "plan"_a, nb::kw_only(), "speed"_a = execution::kOpenLoopSpeed, "pause"_a = 0.0,
        R"(Gives times to the commands of a plan, for execution without feedback.

The full speed follows from the object of the goal and from the motors (E.8), (E.13). If an object moves on a damped joint, the commands
lead the plan to compensate the damping (E.17).

  speed: factor on the full speed, > 0. A factor above 1 makes only pushes faster. Without feedback most plans succeed at the default of
    0.1, and few succeed at 1. At any speed, no command is faster than the `velocity` of the URDF.
  pause: time for which the command is constant between pushes and regrasps [s], >= 0.

Returns a Trajectory. Raises InvalidInput.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> trajectory = st.make_trajectory(plan, speed=0.5)
    >>> trajectory.u.shape == (len(trajectory.times), 2), float(trajectory.times[0]), trajectory.speed
    (True, 0.0, 0.5))");
}

void bind_plan_contact(nb::module_& m) {
  const auto number = [](double tasks::StoredContact::*member) { return [member](const PlanContact& c) { return c.contact.*member; }; };
  const auto vector = [](Eigen::Vector3d tasks::StoredContact::*member) {
    return [member](const PlanContact& c) { return c.contact.*member; };
  };
  using tasks::StoredContact;
  nb::class_<PlanContact>(m, "PlanContact",
                          "An active contact at a knot of a plan. Numbers are rounded to 1e-6 if the plan was read from a file.")
      .def_ro("a", &PlanContact::a, "name of the first geometry, as body/geometry")
      .def_ro("b", &PlanContact::b, "name of the second geometry")
      .def_prop_ro("point", vector(&StoredContact::point_W), "contact point in W, on the surface of b before the sub-step [m] (3)")
      .def_prop_ro("normal", vector(&StoredContact::normal_W), "unit normal in W, from b to a (3)")
      .def_prop_ro("force", vector(&StoredContact::force_W), "contact force in W, which acts on a; the opposite force acts on b [N] (3)")
      .def_prop_ro("friction", number(&StoredContact::friction), "friction coefficient of the pair")
      .def_prop_ro("gap", number(&StoredContact::gap), "signed distance before the sub-step [m]")
      .def_prop_ro("moment", number(&StoredContact::moment), "moment about the normal, which acts on a [N m]")
      .def("__repr__", [](const PlanContact& c) {
        return fmt::format("<stiction.PlanContact: {} on {}, {:.4g} N>", c.b, c.a, c.contact.force_W.norm());
      });
}

/// Files for others are written by the module stiction.exports.
nb::object export_plan(nb::handle plan, const std::filesystem::path& file, const std::optional<std::string>& format,
                       const std::optional<execution::Trajectory>& trajectory) {
  return nb::module_::import_("stiction.exports").attr("write")(plan, file, "format"_a = format, "trajectory"_a = trajectory);
}

}  // namespace

void bind_plan(nb::module_& m) {
  bind_plan_contact(m);
  bind_trajectory(m);
  using tasks::StoredSegment;
  nb::class_<StoredSegment>(m, "Segment", "A part of a plan with one kind of motion; its knots are one sub-step apart.")
      .def_ro("kind", &StoredSegment::kind, "Settle, Contact or Regrasp")
      .def_prop_ro(
          "q", [](const StoredSegment& s) { return knots_of(s, kQ); }, "configurations (knots, n_q)")
      .def_prop_ro(
          "u", [](const StoredSegment& s) { return knots_of(s, kU); }, "commands (knots, n_a) [m or rad]");
  nb::class_<Plan>(m, "Plan",
                   R"(Commands and predicted configurations from the start towards the goal, together with the task.

A plan is a sequence of segments: plan[i] is a Segment and plan[i:j] is a Plan. It can be pickled.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> plan.q.shape == (len(plan.u), 5), len(plan) == len(plan.segments)
    (True, True)
    >>> first = plan[:1]
    >>> first.q.shape == (1 + len(plan[0].q), 5)
    True)")
      .def_ro("task", &Plan::task, "task that the plan was made for")
      .def_prop_ro(
          "options",
          [](const Plan& p) {
            return PlannerOptions{p.task.model, tasks::options_of_plan(p.model(), p.file, "plan")};
          },
          "options with which the plan was made")
      .def_prop_ro(
          "status", [](const Plan& p) { return p.file.status; }, "Solved: the plan reaches the goal")
      .def_prop_ro(
          "seed", [](const Plan& p) { return p.file.seed; }, "seed of the search")
      .def_prop_ro(
          "error", [](const Plan& p) { return p.file.error; }, "distance of the object from the goal at the last knot")
      .def_prop_ro(
          "h", [](const Plan& p) { return p.file.step.h; }, "time step of one knot [s]")
      .def_prop_ro(
          "segments", [](const Plan& p) { return p.file.segments; }, "list of the segments")
      .def("__len__", [](const Plan& p) { return p.file.segments.size(); })
      .def(
          "__iter__", [](nb::handle self) { return nb::iter(self.attr("segments")); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[Segment]"))
      .def("__getitem__", &segment, "index"_a, "Returns one segment. Raises IndexError.")
      .def("__getitem__", &slice, "segments"_a,
           "Returns neighbouring segments as a plan. It starts at the end of the preceding segment, and is Solved if it ends at the goal. "
           "Raises InvalidInput: no segment.")
      .def_prop_ro(
          "q", [](const Plan& p) { return path(p.file, p.file.q_start, kQ); }, "predicted configurations, the start first (knots + 1, n_q)")
      .def_prop_ro(
          "u", [](const Plan& p) { return path(p.file, p.file.u_start, kU); }, "commands, the start first (knots + 1, n_a) [m or rad]")
      .def(
          "write", [](const Plan& p, const std::filesystem::path& file) { tasks::write_plan(p.at(file), file); }, "file"_a,
          nb::call_guard<nb::gil_scoped_release>(),
          "Writes the plan to a file, which read_plan() and the commands of the program read (docs/plan_file.md). Raises InvalidInput.")
      .def_prop_ro("contacts", &contacts_of,
                   "for each row of q, the contacts that were active in the sub-step before it (knots + 1); none at the start")
      .def("export", &export_plan, "file"_a, nb::kw_only(), "format"_a = nb::none(), "trajectory"_a = nb::none(),
           nb::sig("def export(self, file: str | os.PathLike, *, format: str | None = None, trajectory: Trajectory | None = None) -> "
                   "list[pathlib.Path]"),
           R"(Writes the motion over time in a format of other programs (docs/exports.md).

The file holds joint positions, commands, velocities, torques, object poses and contacts.

  file: the file to write, or the folder for the format lerobot.
  format: csv, npz, json, mcap or lerobot. None: the suffix of the file name decides.
  trajectory: from make_trajectory(). None: a trajectory at the default speed.

Returns the paths of the written files. Raises InvalidInput; MissingExtra: mcap needs `pip install stiction[mcap]`.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> [file.name for file in plan.export("motion.csv")]
    ['motion.csv', 'motion.contacts.csv']
    >>> with np.load(plan.export("motion.npz")[0]) as motion:
    ...     motion["q"].shape == (len(motion["time"]), 2)
    True)")
      .def("to_text", &to_text, "folder"_a = nb::none(),
           "Returns the text of the plan file. The path of the task in it is relative to `folder`; None: the working folder.")
      .def("__getstate__",
           [](const Plan& p) {
             const std::string folder = folder_of({}).string();
             return std::tuple(to_text(p, folder), folder);
           })
      .def("__setstate__",
           [](Plan& p, const std::tuple<std::string, std::string>& state) {
             const auto& [text, folder] = state;
             const std::filesystem::path file = std::filesystem::path(folder) / "plan.json";
             new (&p) Plan(tasks::parse_plan(text, file), file);
           })
      .def("__repr__", [](const Plan& p) {
        return fmt::format("<stiction.Plan of '{}': {}, {} segments, {:.4g} m and {:.4g} rad from the goal>", p.task.name,
                           core::to_string(p.file.status), p.file.segments.size(), p.file.error.position, p.file.error.angle);
      });
  m.def("read_plan", &read_plan, "file"_a, nb::call_guard<nb::gil_scoped_release>(),
        R"(Reads a plan from a file, or from a folder that has a plan.json, and loads the task that the plan was made for.

Raises InvalidInput with the text "FILE: field: got …, expected …", also if the scene of the task has changed since.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> plan.write("plan.json")
    >>> bool((st.read_plan("plan.json").q == plan.q).all())
    True)");
  m.def("parse_plan", &parse_plan, "text"_a, "folder"_a = nb::none(), nb::call_guard<nb::gil_scoped_release>(),
        R"(Makes a plan from the text of a plan file, as Plan.to_text() returns it.

  folder: folder to which the path of the task in the text is relative. None: the working folder.

Raises InvalidInput.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> st.parse_plan(plan.to_text()).seed
    0)");
  bind_refine(m);
  bind_check(m);
  def_pickle<CheckItem, CheckReport, Refined, execution::Trajectory, PlanContact, StoredSegment>();
}

}  // namespace stiction::python
