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
  return std::make_shared<Plan>(tasks::parse_plan(text, file), file);
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
  const nb::gil_scoped_release unlocked;
  (void)tasks::check_plan(plan.task, plan.file, {}, {}, *out);
  return out;
}

execution::Trajectory make_trajectory(const Plan& plan, double speed, double pause) {
  return execution::make_trajectory(plan.model(), tasks::to_plan(plan.model(), plan.file), speed, pause);
}

void bind_check(nb::module_& m) {
  nb::class_<CheckItem>(m, "CheckItem", "One figure of a check.")
      .def_ro("name", &CheckItem::name)
      .def_ro("value", &CheckItem::value, "in `unit`")
      .def_ro("limit", &CheckItem::limit, "the largest good value; None: reported, not judged")
      .def_ro("unit", &CheckItem::unit)
      .def_ro("pass_", &CheckItem::pass)
      .def_ro("where", &CheckItem::where, "what and where the worst was")
      .def("__repr__", [](const CheckItem& c) {
        return fmt::format("<stiction.CheckItem: {} {:.4g} {}, {}>", c.name, c.value, c.unit, c.pass ? "passed" : "failed");
      });
  nb::class_<CheckReport>(m, "CheckReport", "What came of a check.")
      .def_ro("pass_", &CheckReport::pass, "the verdict")
      .def_ro("status", &CheckReport::status, "Solved: all checks were made")
      .def_ro("items", &CheckReport::items)
      .def("at", &CheckReport::at, "name"_a, nb::rv_policy::copy, "one item by its name. Raises InvalidInput: no such item")
      .def_ro("knots", &CheckReport::knots)
      .def_ro("steps", &CheckReport::steps)
      .def_ro("threshold_N", &CheckReport::threshold_N, "contacts with less force than this are not looked at [N]")
      .def_ro("wall_s", &CheckReport::wall_s)
      .def("__repr__", [](const CheckReport& r) {
        std::string failed;
        for (const auto& item : r.items) {
          if (!item.pass) failed += (failed.empty() ? ": " : ", ") + item.name;
        }
        return fmt::format("<stiction.CheckReport: {}{}>", r.pass ? "passed" : "failed", failed);
      });
  m.def("check_plan", &check_plan, "plan"_a,
        "Simulates a plan anew with the exact dynamics at half the sub-step, and compares every number in it with what comes out and with "
        "its "
        "task. The check shares nothing with the planner."
        R"(

    >>> report = st.check_plan(st.plan(st.load_task("planar_pushing"), seed=0).plan)
    >>> report.pass_, report.at("goal_position").unit
    (True, 'm'))");
}

void bind_refine(nb::module_& m) {
  nb::class_<Refined>(m, "RefineResult", "What came of a refinement.")
      .def_prop_ro("status", [](const Refined& r) { return r.result.status; })
      .def_ro("plan", &Refined::plan, "the refined plan, or the given one")
      .def_prop_ro(
          "variant", [](const Refined& r) { return r.result.variant; }, "shortened, reconnected or unchanged")
      .def_prop_ro(
          "pushes", [](const Refined& r) { return std::pair(r.result.pushes_before, r.result.pushes); }, "before and after")
      .def_prop_ro(
          "regrasps", [](const Refined& r) { return std::pair(r.result.regrasps_before, r.result.regrasps); }, "before and after")
      .def_prop_ro(
          "least_clearance", [](const Refined& r) { return r.result.least_clearance; },
          "of the regrasps that were planned anew [m]; 0 without any")
      .def_prop_ro(
          "rest_planned_anew", [](const Refined& r) { return r.result.rest_planned_anew; },
          "searches for what small steps left of the plan")
      .def_prop_ro("steps", [](const Refined& r) { return r.result.steps; })
      .def_prop_ro("failed_steps", [](const Refined& r) { return r.result.failed_steps; })
      .def_prop_ro("wall_s", [](const Refined& r) { return r.result.wall_s; })
      .def("__repr__", [](const Refined& r) {
        return fmt::format("<stiction.RefineResult: {}, {}>", core::to_string(r.result.status), r.result.variant);
      });
  m.def("refine", &refine, "plan"_a, nb::kw_only(), "options"_a = nb::none(), "threads"_a = nb::none(), "timeout_s"_a = 20.0,
        "on_progress"_a = nb::none(),
        "Makes a plan shorter and its regrasps wider (docs/theory/refinement.md).\n\n"
        "plan: one that is Solved. options: PlannerOptions, or a dict of those that differ; None: those that the plan was made with. "
        "threads: "
        "0 for all cores; the result does not depend on them. timeout_s: [s] > 0.\n\n"
        "status: Solved; MaxIterations (time used up) and Cancelled: refined at its own steps, or the given plan; NumericalFailure: the "
        "given "
        "plan does not reach its goal. Raises InvalidInput."
        R"(

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> refined = st.refine(plan)
    >>> refined.status, st.check_plan(refined.plan).pass_
    (Status.Solved, True))");
}

void bind_trajectory(nb::module_& m) {
  using execution::Trajectory;
  nb::class_<Trajectory>(m, "Trajectory", "Commands over time, linear between knots, and the configurations that the plan predicts.")
      .def_ro("times", &Trajectory::times, "of the knots, the first one 0 [s] (knots)")
      .def_prop_ro(
          "u", [](const Trajectory& t) { return rows(t.u); }, "(knots, n_a) [m or rad]")
      .def_prop_ro(
          "q", [](const Trajectory& t) { return rows(t.q); }, "(knots, n_q)")
      .def_ro("segments", &Trajectory::segments, "of the plan, that led to the knot (knots)")
      .def_ro("knots", &Trajectory::knots, "rows of Plan.q: the knot of the plan whose sub-step ends here or is under way (knots)")
      .def_ro("speed", &Trajectory::speed, "times the full timing of make_trajectory()")
      .def_prop_ro("duration", &Trajectory::duration, "[s]");
  m.attr("OPEN_LOOP_SPEED") = execution::kOpenLoopSpeed;
  m.def(
      "make_trajectory", &make_trajectory, "plan"_a, nb::kw_only(), "speed"_a = execution::kOpenLoopSpeed, "pause"_a = 0.0,
      "Times of the commands of a plan, at the speeds that follow from the object of its goal and from the motors (E.8), (E.13), and ahead "
      "of it by what the damping of objects on joints takes (E.17).\n\n"
      "speed: times that full timing, > 0; above 1 only pushes are faster. Without feedback most plans hold at the default of 0.1, and few "
      "at 1. No command is faster than the `velocity` of the URDF, at any speed. pause: commands rest this long between pieces [s], >= 0. "
      "Raises InvalidInput."
      R"(

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> trajectory = st.make_trajectory(plan, speed=0.5)
    >>> trajectory.u.shape == (len(trajectory.times), 2), float(trajectory.times[0]), trajectory.speed
    (True, 0.0, 0.5))");
}

void bind_contact(nb::module_& m) {
  const auto number = [](double tasks::StoredContact::*member) { return [member](const PlanContact& c) { return c.contact.*member; }; };
  const auto vector = [](Eigen::Vector3d tasks::StoredContact::*member) {
    return [member](const PlanContact& c) { return c.contact.*member; };
  };
  using tasks::StoredContact;
  nb::class_<PlanContact>(m, "PlanContact", "An active contact of a knot of a plan; rounded to 1e-6 where the plan was read from a file.")
      .def_ro("a", &PlanContact::a, "name of the geometry, as body/geometry")
      .def_ro("b", &PlanContact::b)
      .def_prop_ro("point", vector(&StoredContact::point_W), "in W, on the surface of b before the sub-step [m] (3)")
      .def_prop_ro("normal", vector(&StoredContact::normal_W), "unit, from b to a (3)")
      .def_prop_ro("force", vector(&StoredContact::force_W), "in W, on a; its opposite acts on b [N] (3)")
      .def_prop_ro("friction", number(&StoredContact::friction), "coefficient of the pair")
      .def_prop_ro("gap", number(&StoredContact::gap), "signed distance before the sub-step [m]")
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
  bind_contact(m);
  bind_trajectory(m);
  using tasks::StoredSegment;
  nb::class_<StoredSegment>(m, "Segment", "A piece of a plan: knots one sub-step apart.")
      .def_ro("kind", &StoredSegment::kind)
      .def_prop_ro(
          "q", [](const StoredSegment& s) { return knots_of(s, kQ); }, "(knots, n_q)")
      .def_prop_ro(
          "u", [](const StoredSegment& s) { return knots_of(s, kU); }, "(knots, n_a)");
  nb::class_<Plan>(
      m, "Plan",
      R"(Commands and predicted configurations from the start to (near) the goal, with the task. Can be pickled; a sequence of segments.

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> plan.q.shape == (len(plan.u), 5), len(plan) == len(plan.segments)
    (True, True)
    >>> first = plan[:1]
    >>> first.q.shape == (1 + len(plan[0].q), 5)
    True)")
      .def_ro("task", &Plan::task)
      .def_prop_ro(
          "options",
          [](const Plan& p) {
            return PlannerOptions{p.task.model, tasks::options_of_plan(p.model(), p.file, "plan")};
          },
          "that it was made with")
      .def_prop_ro(
          "status", [](const Plan& p) { return p.file.status; }, "Solved: it reaches the goal")
      .def_prop_ro("seed", [](const Plan& p) { return p.file.seed; })
      .def_prop_ro(
          "error", [](const Plan& p) { return p.file.error; }, "of the object at the last knot")
      .def_prop_ro(
          "h", [](const Plan& p) { return p.file.step.h; }, "time step of a knot [s]")
      .def_prop_ro("segments", [](const Plan& p) { return p.file.segments; })
      .def("__len__", [](const Plan& p) { return p.file.segments.size(); })
      .def(
          "__iter__", [](nb::handle self) { return nb::iter(self.attr("segments")); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[Segment]"))
      .def("__getitem__", &segment, "index"_a, "One of the segments. Raises IndexError.")
      .def("__getitem__", &slice, "segments"_a,
           "Neighbouring segments as a plan, which starts where the one before them ends. Solved where it ends at the goal. Raises "
           "InvalidInput: no segment")
      .def_prop_ro(
          "q", [](const Plan& p) { return path(p.file, p.file.q_start, kQ); }, "configurations, the start first (knots + 1, n_q)")
      .def_prop_ro(
          "u", [](const Plan& p) { return path(p.file, p.file.u_start, kU); }, "commands (knots + 1, n_a) [m or rad]")
      .def(
          "write", [](const Plan& p, const std::filesystem::path& file) { tasks::write_plan(p.at(file), file); }, "file"_a,
          nb::call_guard<nb::gil_scoped_release>(), "Writes the plan file that the program reads (docs/plan_file.md). Raises InvalidInput.")
      .def_prop_ro("contacts", &contacts_of, "active in the sub-step that led to each row of q; none at the start (knots + 1)")
      .def("export", &export_plan, "file"_a, nb::kw_only(), "format"_a = nb::none(), "trajectory"_a = nb::none(),
           nb::sig("def export(self, file: str | os.PathLike, *, format: str | None = None, trajectory: Trajectory | None = None) -> "
                   "list[pathlib.Path]"),
           "Writes the motion over time for other programs (docs/exports.md): joints, commands, velocities, torques, poses of objects, "
           "contacts.\n\n"
           "format: csv, npz, json, mcap or lerobot (a folder); None: what the name of the file ends in. trajectory: of make_trajectory(); "
           "None: at its "
           "default speed. Returns the files. Raises InvalidInput; MissingExtra: mcap needs `pip install stiction[mcap]`."
           R"(

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> [file.name for file in plan.export("motion.csv")]
    ['motion.csv', 'motion.contacts.csv']
    >>> with np.load(plan.export("motion.npz")[0]) as motion:
    ...     motion["q"].shape == (len(motion["time"]), 2)
    True)")
      .def("to_text", &to_text, "folder"_a = nb::none(), "The text of the file as it would stand in the folder; None: the working folder.")
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
        "A plan from its file, or the folder of a plan.json, with the task it was made for. Raises InvalidInput: \"FILE: field: got …, "
        "expected "
        "…\", also where the scene of the task is another one by now."
        R"(

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> plan.write("plan.json")
    >>> bool((st.read_plan("plan.json").q == plan.q).all())
    True)");
  m.def("parse_plan", &parse_plan, "text"_a, "folder"_a = nb::none(), nb::call_guard<nb::gil_scoped_release>(),
        "A plan from the text of its file. folder: in which the text stands, None: the working folder. Raises InvalidInput."
        R"(

    >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
    >>> st.parse_plan(plan.to_text()).seed
    0)");
  bind_refine(m);
  bind_check(m);
  def_pickle<CheckItem, CheckReport, Refined, execution::Trajectory, PlanContact, StoredSegment>();
}

}  // namespace stiction::python
