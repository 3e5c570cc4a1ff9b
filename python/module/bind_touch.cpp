#include "bind_touch.hpp"

#include <fmt/format.h>
#include <nanobind/stl/unique_ptr.h>

#include <cmath>

#include "pickles.hpp"
#include "scenario_file.hpp"
#include "stiction/execution/touch/touch_run.hpp"
#include "stiction/tasks/touch_scenario_file.hpp"
#include "watcher.hpp"
#include "yaml_text.hpp"

namespace stiction::python {
namespace {

using execution::TouchOutcome;
using execution::TouchRunResult;
using execution::TouchScenario;

/// A touch with the name of its link.
struct Touch {
  std::string link;
  execution::Touch values;
};

struct TouchResult {
  ModelPtr known;
  TouchRunResult result;

  std::vector<Touch> touches() const {
    std::vector<Touch> out;
    for (const auto& touch : result.touches) out.push_back({known->bodies()[static_cast<std::size_t>(touch.body)].name, touch});
    return out;
  }
};

TouchScenario parse(const nb::dict& scenario, const std::optional<std::filesystem::path>& base) {
  const std::string text = yaml_text(scenario);
  const auto folder = folder_of(base);
  const nb::gil_scoped_release unlocked;
  return tasks::parse_touch_scenario(text, folder, tasks::default_package_dirs());
}

std::unique_ptr<TouchResult> run(const TouchScenario& scenario, std::optional<std::uint64_t> seed, double settle,
                                 std::optional<double> timeout_s) {
  auto out = std::make_unique<TouchResult>();
  execution::TouchRunOptions options = touch_options(scenario, seed, settle);
  Interrupt interrupt;
  options.control = interrupt.control(timeout_s);
  {
    const nb::gil_scoped_release unlocked;
    (void)execution::run_touch(scenario, options, out->result);
    out->known = scenario.arm.model;
  }
  interrupt.rethrow();
  return out;
}

std::unique_ptr<TouchResult> run_file(const ScenarioFile& scenario, std::optional<std::uint64_t> seed, double settle,
                                      std::optional<double> timeout_s) {
  return run(load_touch_scenario(scenario), seed, settle, timeout_s);
}

void bind_scenario(nb::module_& m) {
  const auto of_arm = [](auto member) { return [member](const TouchScenario& s) { return s.arm.*member; }; };
  using execution::ControlScenario;
  nb::class_<TouchScenario>(m, "TouchScenario",
                            "An arm that goes to a posture among things that it does not know, as a file says (scenarios/README.md).")
      .def_prop_ro("name", of_arm(&ControlScenario::name))
      .def_prop_ro("description", of_arm(&ControlScenario::description))
      .def_prop_ro("file", of_arm(&ControlScenario::file))
      .def_prop_ro("model", of_arm(&ControlScenario::model), "what the arm knows")
      .def_prop_ro("start", of_arm(&ControlScenario::start), "joint positions (n_a) [rad or m]")
      .def_ro("goal", &TouchScenario::goal, "joint positions (n_a) [rad or m]")
      .def_ro("tolerance", &TouchScenario::tolerance, "of the largest joint at the goal [rad; m in lengths of the robots]")
      .def_ro("speed", &TouchScenario::speed, "of any point of the arm, at most [m/s]")
      .def_ro("max_touches", &TouchScenario::max_touches, "after which the arm gives up")
      .def_prop_ro(
          "lambda_max", [](const TouchScenario& s) { return s.arm.controller.lambda_max; }, "[N]")
      .def(
          "make_world", [](const TouchScenario& s, std::uint64_t seed) { return execution::make_world(s, seed); }, "seed"_a = 0,
          nb::call_guard<nb::gil_scoped_release>(),
          "The model with what is not known, where it is for this seed. Raises InvalidInput: the start touches something.")
      .def("__repr__", [](const TouchScenario& s) { return fmt::format("<stiction.TouchScenario '{}'>", s.arm.name); });
}

void bind_parts(nb::module_& m) {
  nb::enum_<TouchOutcome>(m, "TouchOutcome", "How a touch run ended.")
      .value("Reached", TouchOutcome::Reached)
      .value("NoRoute", TouchOutcome::NoRoute, "the arm holds where it is")
      .value("TooManyTouches", TouchOutcome::TooManyTouches, "the same")
      .value("Missed", TouchOutcome::Missed, "at the end of its path the arm is not at the goal, and feels nothing");
  const auto of = [](auto member) { return [member](const Touch& t) { return t.values.*member; }; };
  using Values = execution::Touch;
  nb::class_<Touch>(m, "Touch", "A contact that was felt long enough to be told of.")
      .def_prop_ro("time", of(&Values::time), "when it was told [s]")
      .def_ro("link", &Touch::link, "as robot/link")
      .def_prop_ro(
          "p_W", [](const Touch& t) { return t.values.place.p_W; }, "where, from torques [m] (3)")
      .def_prop_ro(
          "n_W", [](const Touch& t) { return t.values.place.n_W; }, "unit, out of what was touched (3)")
      .def_prop_ro(
          "spread", [](const Touch& t) { return t.values.place.spread; }, "deviation of the estimates [m]")
      .def_prop_ro("force", of(&Values::force), "mean of the estimates [N]")
      .def_prop_ro("radius", of(&Values::radius), "of the ball that stands for it from then on (G.2) [m]")
      .def_prop_ro(
          "error",
          [](const Touch& t) -> std::optional<double> {
            return std::isfinite(t.values.error) ? std::optional(t.values.error) : std::nullopt;
          },
          "distance from the nearest contact of the simulation [m]; None: there was none")
      .def("__repr__", [](const Touch& t) { return fmt::format("<stiction.Touch: {}, {:.3g} N>", t.link, t.values.force); });
  nb::class_<execution::PlannedRoute>(m, "TouchRoute", "A way to the goal among what was known then.")
      .def_ro("time", &execution::PlannedRoute::time, "when it was found [s]")
      .def_prop_ro("found", [](const execution::PlannedRoute& r) { return r.route.outcome == contact::PathOutcome::Found; })
      .def_prop_ro(
          "postures",
          [](const execution::PlannedRoute& r) {
            const auto& postures = r.route.postures;
            return rows(postures, postures.empty() ? 0 : postures.front().size(), [](const Eigen::VectorXd& q) { return q.transpose(); });
          },
          "to the goal, both ends included (postures, n_a) [rad or m]")
      .def_prop_ro(
          "travel", [](const execution::PlannedRoute& r) { return r.route.travel; }, "its length (G.1) [m]")
      .def_ro("wall_s", &execution::PlannedRoute::wall_s, "that the search took");
}

}  // namespace

TouchScenario load_touch_scenario(const ScenarioFile& scenario) {
  const auto file = file_of(scenario);
  const nb::gil_scoped_release unlocked;
  return tasks::load_touch_scenario(file, tasks::default_package_dirs());
}

execution::TouchRunOptions touch_options(const TouchScenario& scenario, std::optional<std::uint64_t> seed, double settle) {
  execution::TouchRunOptions options;
  options.seed = seed.value_or(scenario.arm.observer.seed);
  options.settle = settle;
  return options;
}

void bind_touch(nb::module_& m) {
  bind_scenario(m);
  bind_parts(m);
  const auto of = [](auto member) { return [member](const TouchResult& r) { return r.result.*member; }; };
  nb::class_<TouchResult>(m, "TouchResult", "What came of going to a posture among unknown things.")
      .def_prop_ro("status", of(&TouchRunResult::status))
      .def_prop_ro("outcome", of(&TouchRunResult::outcome))
      .def_prop_ro(
          "reached",
          [](const TouchResult& r) { return r.result.status == core::Status::Solved && r.result.outcome == TouchOutcome::Reached; })
      .def_prop_ro("reason", of(&TouchRunResult::reason), "why the goal was not reached, or what the simulation said")
      .def_prop_ro("touches", &TouchResult::touches)
      .def_prop_ro("routes", of(&TouchRunResult::routes), "the first before the first motion, then one after each touch")
      .def_prop_ro("goal_error", of(&TouchRunResult::goal_error), "of the largest joint at the end [rad; m in lengths of the robots]")
      .def_prop_ro("run", of(&TouchRunResult::run), "series and forces of the whole run")
      .def_prop_ro("world", of(&TouchRunResult::world), "what was simulated")
      .def_prop_ro("map", of(&TouchRunResult::map),
                   "what the arm knows at the end: the scene, and a ball touch_1, touch_2, … for each place")
      .def("__repr__", [](const TouchResult& r) {
        return fmt::format("<stiction.TouchResult: {}, {} touches>", execution::to_string(r.result.outcome), r.result.touches.size());
      });
  m.def("load_touch_scenario", &load_touch_scenario, "scenario"_a,
        "A scenario of touch: the name of a built-in one, or a file. Raises InvalidInput: \"FILE:LINE: field: got …\"."
        R"(

    >>> scenario = st.load_touch_scenario("reach_past_pillar")
    >>> scenario.goal.shape == scenario.start.shape, scenario.lambda_max
    (True, 15.0))");
  m.def("load_touch_scenario", &parse, "scenario"_a, nb::kw_only(), "base"_a = nb::none(),
        "The same of a dict, with the keys of a file. base: the folder that paths in it are relative to; None: the working folder. Raises "
        "InvalidInput: \"field: got …\".");
  const auto def = [&m](auto function, const char* doc) {
    m.def("touch", function, "scenario"_a, nb::kw_only(), "seed"_a = nb::none(), "settle"_a = execution::TouchRunOptions{}.settle,
          "timeout_s"_a = nb::none(), doc);
  };
  def(&run, R"(An arm goes to its goal with bounded forces, locates what it meets from joint torques, and plans around it.

  seed: of torque noise, of where the unknown is and of paths; None: the scenario's.
  settle: forces are called steady this long after their contact was made [s], >= 0.
  timeout_s: [s] > 0; None: as long as it takes.

status: Solved: `outcome` says to what; MaxIterations (time used up); NumericalFailure (`reason`). Raises InvalidInput.

    >>> run = st.touch("reach_past_pillar", seed=0)
    >>> run.outcome, len(run.touches) > 0, run.run.q.shape == (len(run.run.times), 7)
    (TouchOutcome.Reached, True, True))");
  def(&run_file, "The same of load_touch_scenario(scenario).");
  def_pickle<TouchScenario, Touch, execution::PlannedRoute, TouchResult>();
}

}  // namespace stiction::python
