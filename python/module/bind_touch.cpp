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
  nb::class_<TouchScenario>(
      m, "TouchScenario",
      "Scenario for touch() and guarded_moves(): an arm with torque sensors among obstacles that it does not know (scenarios/README.md).")
      .def_prop_ro("name", of_arm(&ControlScenario::name), "name of the scenario")
      .def_prop_ro("description", of_arm(&ControlScenario::description), "one line about the scenario")
      .def_prop_ro("file", of_arm(&ControlScenario::file), "path of the scenario file")
      .def_prop_ro("model", of_arm(&ControlScenario::model), "model that the arm knows")
      .def_prop_ro("start", of_arm(&ControlScenario::start), "joint positions at the start (n_a) [rad or m]")
      .def_ro("goal", &TouchScenario::goal, "joint positions at the goal (n_a) [rad or m]")
      .def_ro("tolerance", &TouchScenario::tolerance,
              "largest joint error at the goal; revolute joints [rad], prismatic joints in lengths of the robots")
      .def_ro("speed", &TouchScenario::speed, "largest speed of any point of the arm [m/s]")
      .def_ro("max_touches", &TouchScenario::max_touches, "number of touches after which the arm gives up")
      .def_prop_ro(
          "lambda_max", [](const TouchScenario& s) { return s.arm.controller.lambda_max; }, "bound on contact forces [N]")
      .def(
          "make_world", [](const TouchScenario& s, std::uint64_t seed) { return execution::make_world(s, seed); }, "seed"_a = 0,
          nb::call_guard<nb::gil_scoped_release>(),
          "Returns the true model, in which the unknown bodies are at their places for this seed. Raises InvalidInput: the start touches "
          "something.")
      .def("__repr__", [](const TouchScenario& s) { return fmt::format("<stiction.TouchScenario '{}'>", s.arm.name); });
}

void bind_parts(nb::module_& m) {
  nb::enum_<TouchOutcome>(m, "TouchOutcome", "How a run of touch() ended.")
      .value("Reached", TouchOutcome::Reached, "the arm is at the goal")
      .value("NoRoute", TouchOutcome::NoRoute, "there is no path to the goal among the known obstacles; the arm holds its position")
      .value("TooManyTouches", TouchOutcome::TooManyTouches, "max_touches is used up; the arm holds its position")
      .value("Missed", TouchOutcome::Missed, "the arm is at the end of its path but not at the goal, and feels no contact");
  const auto of = [](auto member) { return [member](const Touch& t) { return t.values.*member; }; };
  using Values = execution::Touch;
  nb::class_<Touch>(m, "Touch", "Contact that the arm felt long enough to locate it.")
      .def_prop_ro("time", of(&Values::time), "time at which the contact was located [s]")
      .def_ro("link", &Touch::link, "link in contact, as robot/link")
      .def_prop_ro(
          "p_W", [](const Touch& t) { return t.values.place.p_W; }, "contact point in W, as estimated from joint torques [m] (3)")
      .def_prop_ro(
          "n_W", [](const Touch& t) { return t.values.place.n_W; }, "unit normal in W, out of the obstacle (3)")
      .def_prop_ro(
          "spread", [](const Touch& t) { return t.values.place.spread; }, "standard deviation of the estimated points [m]")
      .def_prop_ro("force", of(&Values::force), "mean of the estimated forces [N]")
      .def_prop_ro("radius", of(&Values::radius), "radius of the ball that represents the obstacle in the map from then on (G.2) [m]")
      .def_prop_ro(
          "error",
          [](const Touch& t) -> std::optional<double> {
            return std::isfinite(t.values.error) ? std::optional(t.values.error) : std::nullopt;
          },
          "distance from the nearest true contact in the simulation [m]; None: there was no contact")
      .def("__repr__", [](const Touch& t) { return fmt::format("<stiction.Touch: {}, {:.3g} N>", t.link, t.values.force); });
  nb::class_<execution::PlannedRoute>(m, "TouchRoute", "Path to the goal among the obstacles that were known at that time.")
      .def_ro("time", &execution::PlannedRoute::time, "time at which the path was found [s]")
      .def_prop_ro(
          "found", [](const execution::PlannedRoute& r) { return r.route.outcome == contact::PathOutcome::Found; }, "True: there is a path")
      .def_prop_ro(
          "postures",
          [](const execution::PlannedRoute& r) {
            const auto& postures = r.route.postures;
            return rows(postures, postures.empty() ? 0 : postures.front().size(), [](const Eigen::VectorXd& q) { return q.transpose(); });
          },
          "joint positions along the path, both ends included (postures, n_a) [rad or m]")
      .def_prop_ro(
          "travel", [](const execution::PlannedRoute& r) { return r.route.travel; }, "length of the path (G.1) [m]")
      .def_ro("wall_s", &execution::PlannedRoute::wall_s, "wall time of the search [s]");
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
  nb::class_<TouchResult>(m, "TouchResult", "Result of touch().")
      .def_prop_ro("status", of(&TouchRunResult::status), "see touch()")
      .def_prop_ro("outcome", of(&TouchRunResult::outcome), "how the run ended")
      .def_prop_ro(
          "reached",
          [](const TouchResult& r) { return r.result.status == core::Status::Solved && r.result.outcome == TouchOutcome::Reached; },
          "True: the arm reached its goal")
      .def_prop_ro("reason", of(&TouchRunResult::reason), "why the goal was not reached, or the error of the simulation")
      .def_prop_ro("touches", &TouchResult::touches, "contacts that the arm located")
      .def_prop_ro("routes", of(&TouchRunResult::routes), "paths: one before the first motion, then one after each touch")
      .def_prop_ro("goal_error", of(&TouchRunResult::goal_error),
                   "largest joint error at the end; revolute joints [rad], prismatic joints in lengths of the robots")
      .def_prop_ro("run", of(&TouchRunResult::run), "samples and forces of the whole run")
      .def_prop_ro("world", of(&TouchRunResult::world), "model that was simulated")
      .def_prop_ro("map", of(&TouchRunResult::map),
                   "model that the arm knows at the end: the scene, with a ball touch_1, touch_2, … at each located contact")
      .def("__repr__", [](const TouchResult& r) {
        return fmt::format("<stiction.TouchResult: {}, {} touches>", execution::to_string(r.result.outcome), r.result.touches.size());
      });
  m.def("load_touch_scenario", &load_touch_scenario, "scenario"_a,
        "Loads a scenario for touch() or guarded_moves(): the name of a built-in one, or a file. Raises InvalidInput: \"FILE:LINE: field: "
        "got "
        "…\"."
        R"(

    >>> scenario = st.load_touch_scenario("reach_past_pillar")
    >>> scenario.goal.shape == scenario.start.shape, scenario.lambda_max
    (True, 15.0))");
  m.def("load_touch_scenario", &parse, "scenario"_a, nb::kw_only(), "base"_a = nb::none(),
        "Makes a scenario from a dict with the keys of a file. base: folder to which its paths are relative; None: the working folder. "
        "Raises "
        "InvalidInput: \"field: got …\".");
  const auto def = [&m](auto function, const char* doc) {
    m.def("touch", function, "scenario"_a, nb::kw_only(), "seed"_a = nb::none(), "settle"_a = execution::TouchRunOptions{}.settle,
          "timeout_s"_a = nb::none(), doc);
  };
  def(&run,
      R"(Simulates an arm that moves to a goal among unknown obstacles. It bounds contact forces, locates each obstacle that it touches from its
joint torques, and plans around it.

  scenario: TouchScenario of load_touch_scenario() that has a goal, or its name or file.
  seed: of the torque noise, of the places of the unknown obstacles and of the paths. None: the seed of the scenario.
  settle: time after the start of a contact from which its force counts as steady [s], >= 0.
  timeout_s: largest wall time [s], > 0. None: no limit.

Returns a TouchResult. Its status is Solved if the simulation came to its end; `outcome` tells whether the arm reached its goal. Otherwise
it is MaxIterations: the time was used up; or NumericalFailure: see `reason`. Raises InvalidInput.

    >>> run = st.touch("reach_past_pillar", seed=0)
    >>> run.outcome, len(run.touches) > 0, run.run.q.shape == (len(run.run.times), 7)
    (TouchOutcome.Reached, True, True))");
  def(&run_file, "The same for load_touch_scenario(scenario): give the name or file of a scenario.");
  def_pickle<TouchScenario, Touch, execution::PlannedRoute, TouchResult>();
}

}  // namespace stiction::python
