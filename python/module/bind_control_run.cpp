#include <fmt/format.h>

#include "pickles.hpp"
#include "scenario_file.hpp"
#include "stiction/execution/contact_control/control_run.hpp"
#include "stiction/tasks/control_scenario_file.hpp"
#include "watcher.hpp"
#include "yaml_text.hpp"

namespace stiction::python {
namespace {

using control::Law;
using execution::ContactSource;
using execution::ControlRunResult;
using execution::ControlSample;
using execution::ControlScenario;

ControlScenario load(const ScenarioFile& scenario) {
  const auto file = file_of(scenario);
  const nb::gil_scoped_release unlocked;
  return tasks::load_control_scenario(file, tasks::default_package_dirs());
}

ControlScenario parse(const nb::dict& scenario, const std::optional<std::filesystem::path>& base) {
  const std::string text = yaml_text(scenario);
  const auto folder = folder_of(base);
  const nb::gil_scoped_release unlocked;
  return tasks::parse_control_scenario(text, folder, tasks::default_package_dirs());
}

/// What a run has instead of the scenario's.
struct Changes {
  std::optional<Law> law;
  std::optional<double> lambda_max, friction_scale;
  std::optional<ContactSource> contacts;
  std::optional<double> delay, period;
  std::optional<std::uint64_t> seed;
};

void apply(const Changes& changes, ControlScenario& scenario) {
  if (changes.law) scenario.controller.law = *changes.law;
  if (changes.lambda_max) execution::set_lambda_max(scenario, *changes.lambda_max);
  if (changes.friction_scale) {
    core::require_nonnegative("friction_scale", *changes.friction_scale);
    scenario.plant.contact.friction_scale = *changes.friction_scale;
  }
  if (changes.contacts) scenario.contacts = *changes.contacts;
  if (changes.delay) {
    core::require_nonnegative("delay", *changes.delay);
    scenario.delay = *changes.delay;
  }
  if (changes.period) {
    core::require_positive("period", *changes.period);
    scenario.period = *changes.period;
  }
  if (changes.seed) scenario.observer.seed = *changes.seed;
}

ControlRunResult run(ControlScenario scenario, const Changes& changes, double settle, std::optional<double> timeout_s) {
  apply(changes, scenario);
  execution::ControlRunOptions run_options;
  run_options.settle = settle;
  Interrupt interrupt;
  run_options.control = interrupt.control(timeout_s);
  ControlRunResult out;
  {
    const nb::gil_scoped_release unlocked;
    (void)execution::run_control(scenario, run_options, out);
  }
  interrupt.rethrow();
  return out;
}

/// A number of every tick.
template <class F>
auto over_ticks(F field) {
  return [field](const ControlRunResult& r) {
    return vector_of(r.samples, [field](const ControlSample& s) { return static_cast<double>(s.*field); });
  };
}

/// A vector of every tick, (ticks, n).
template <class F>
auto rows_over_ticks(F field) {
  return [field](const ControlRunResult& r) {
    const Eigen::Index n = r.samples.empty() ? 0 : (r.samples.front().*field).size();
    return rows(r.samples, n, [field](const ControlSample& s) -> const Eigen::VectorXd& { return s.*field; });
  };
}

void bind_scenario(nb::module_& m) {
  nb::class_<ControlScenario>(
      m, "ControlScenario",
      "Scenario for control(): a robot whose reference path leads into obstacles that it does not know (scenarios/README.md).")
      .def_ro("name", &ControlScenario::name, "name of the scenario")
      .def_ro("description", &ControlScenario::description, "one line about the scenario")
      .def_ro("file", &ControlScenario::file, "path of the scenario file")
      .def_ro("model", &ControlScenario::model, "model of the scene")
      .def_ro("start", &ControlScenario::start, "joint positions at the start (n_a) [rad or m]")
      .def_prop_ro(
          "tool",
          [](const ControlScenario& s) -> std::optional<std::string> {
            if (s.tool < 0) return std::nullopt;
            return s.model->bodies()[static_cast<std::size_t>(s.tool)].name;
          },
          "link of the tool that is tracked, as robot/link; None: the joints are tracked")
      .def_ro("X_BT", &ControlScenario::X_BT, "pose of the tool in its link")
      .def_ro("duration", &ControlScenario::duration, "length of the run [s]")
      .def_ro("period", &ControlScenario::period, "period of the controller [s]")
      .def_ro("contacts", &ControlScenario::contacts, "source of the contacts that the controller receives")
      .def_ro("delay", &ControlScenario::delay, "age of the contacts when the controller receives them [s]")
      .def_prop_ro(
          "law", [](const ControlScenario& s) { return s.controller.law; }, "control law")
      .def_prop_ro(
          "lambda_max", [](const ControlScenario& s) { return s.controller.lambda_max; }, "bound on contact forces [N]")
      .def(
          "calc_reference",
          [](const ControlScenario& s, double time) {
            core::require_finite("time", time);
            Eigen::VectorXd out;
            execution::calc_reference(s, time, out);
            return out;
          },
          "time"_a,
          R"(Returns the reference at a time [s]: joint positions (n_a) [rad or m]; or for a tool (6)
its displacement from its start pose in W [m] and the rotation vector [rad].)")
      .def("__repr__", [](const ControlScenario& s) { return fmt::format("<stiction.ControlScenario '{}': {:g} s>", s.name, s.duration); });
}

void bind_result(nb::module_& m) {
  using R = ControlRunResult;
  nb::class_<R>(m, "ControlRunResult",
                "Result of control(). Forces are measured forces of single contacts; series have one row for each tick.")
      .def_ro("status", &R::status, "see control()")
      .def_ro("message", &R::message, "reason of a numerical failure")
      .def_prop_ro("times", over_ticks(&ControlSample::time), "times of the ticks [s] (ticks)")
      .def_prop_ro("q", rows_over_ticks(&ControlSample::q), "joint positions (ticks, n_a) [rad or m]")
      .def_prop_ro("q_cmd", rows_over_ticks(&ControlSample::q_cmd), "commands (ticks, n_a) [rad or m]")
      .def_prop_ro("reference", rows_over_ticks(&ControlSample::reference),
                   "reference of the joints (ticks, n_a) or of the tool (ticks, 6)")
      .def_prop_ro("largest_force", over_ticks(&ControlSample::largest_force), "largest force of one contact [N] (ticks)")
      .def_prop_ro("speed", over_ticks(&ControlSample::speed), "norm of the joint velocity [rad/s] (ticks)")
      .def_prop_ro("error", over_ticks(&ControlSample::error),
                   "tracking error: norm of q - q_ref [rad or m], or distance of the tool from its reference [m] (ticks)")
      .def_prop_ro("angle_error", over_ticks(&ControlSample::angle_error), "angle error of the tool [rad] (ticks)")
      .def_prop_ro(
          "bounded",
          [](const R& r) {
            Eigen::Matrix<bool, Eigen::Dynamic, 1> out(static_cast<Eigen::Index>(r.samples.size()));
            for (Eigen::Index i = 0; i < out.size(); ++i) out[i] = r.samples[static_cast<std::size_t>(i)].bounded;
            return out;
          },
          "True for each tick in which a predicted force is at its bound, since the reference asks for more (ticks)")
      .def_prop_ro("slack", over_ticks(&ControlSample::slack), "largest excess of a predicted force over its bound [N] (ticks)")
      .def_prop_ro(
          "forces",
          [](const R& r) {
            std::vector<std::vector<simulation::PairForce>> out;
            for (const ControlSample& s : r.samples) out.push_back(s.forces);
            return out;
          },
          "for each tick, the forces on the robot from pairs of a robot and another body")
      .def_ro("peak_force", &R::peak_force, "largest force [N]")
      .def_ro("settled_peak", &R::settled_peak, "largest force without the first `settle` seconds of each contact [N]")
      .def_ro("settled_ticks", &R::settled_ticks, "number of ticks with a contact that is older than `settle`")
      .def_ro("bounded_ticks", &R::bounded_ticks, "number of these ticks in which the force is at its bound")
      .def_ro("bound_error", &R::bound_error, "mean |f - lambda_max| over the bounded ticks [N]")
      .def_ro("bound_p95", &R::bound_p95, "95th percentile of the force over the bounded ticks [N]")
      .def_ro("mean_force", &R::mean_force, "mean force over the settled ticks [N]")
      .def_ro("makes", &R::makes, "number of times that the robot as a whole made contact")
      .def_ro("rms_error_contact", &R::rms_error_contact, "RMS of the tracking error in contact")
      .def_ro("rms_error_free", &R::rms_error_free, "RMS of the tracking error without contact")
      .def_ro("peak_speed", &R::peak_speed, "largest norm of the joint velocity [rad/s]")
      .def_ro("peak_force_rate", &R::peak_force_rate, "largest rate at which a settled force falls between two ticks [N/s]")
      .def_ro("peak_rise", &R::peak_rise, "largest rise of a settled force between two ticks [N]")
      .def_ro("commanded_rise", &R::commanded_rise, "part of peak_rise that the change of the command explains [N]")
      .def_ro("above_ticks", &R::above_ticks, "number of settled ticks in which a force exceeds its bound by more than a fifth")
      .def_ro("slack_ticks", &R::slack_ticks, "number of ticks in which a bound was relaxed by more than a thousandth")
      .def_ro("unsolved_ticks", &R::unsolved_ticks, "number of ticks without a solution")
      .def_ro("tick_median_s", &R::tick_median_s, "median processor time of update() [s]")
      .def_ro("tick_p99_s", &R::tick_p99_s, "99th percentile of this processor time [s]")
      .def_ro("sense_median_s", &R::sense_median_s, "median processor time of one contact estimate [s]; 0: no estimates")
      .def_ro("sense_p99_s", &R::sense_p99_s, "99th percentile of this processor time [s]")
      .def("__repr__", [](const R& r) {
        return fmt::format("<stiction.ControlRunResult: {}, {} ticks, settled forces up to {:.3g} N>", core::to_string(r.status),
                           r.samples.size(), r.settled_peak);
      });
}

/// A loop with the scenario that it lives by, which two threads cannot use at once.
struct ControlLoop {
  explicit ControlLoop(ControlScenario given) : scenario(std::move(given)), loop(scenario, scenario.model) {}
  ControlScenario scenario;
  execution::ControlLoop loop;
  std::atomic<bool> busy{false};
};

ControlSample tick(ControlLoop& self) {
  const nb::gil_scoped_release unlocked;
  const Occupied occupied(self.busy, "loop");
  Eigen::VectorXd reference;
  execution::calc_reference(self.scenario, self.loop.time() + self.scenario.period, reference);
  ControlSample out;
  if (self.loop.tick(reference, out) != core::Status::Solved) throw core::InvalidInput(self.loop.message());
  return out;
}

void push(ControlLoop& self, const std::string& link, const Vector& force_W, const Vector& p_LP) {
  const Occupied occupied(self.busy, "loop");
  self.loop.hold_push({find_body(self.loop.world(), "link", link), require_vector3("p_LP", p_LP), require_vector3("force_W", force_W)});
}

void bind_loop(nb::module_& m) {
  nb::class_<ControlSample>(m, "ControlSample", "One tick of a ControlLoop: the state at the start of its period, and its command.")
      .def_ro("time", &ControlSample::time, "time at the start of the period [s]")
      .def_ro("q", &ControlSample::q, "joint positions (n_a) [rad or m]")
      .def_ro("q_cmd", &ControlSample::q_cmd, "command (n_a) [rad or m]")
      .def_ro("forces", &ControlSample::forces, "forces on the robot from pairs of a robot and another body, and from push() (pair -1)")
      .def_ro("largest_force", &ControlSample::largest_force, "largest force of one contact [N]")
      .def_ro("error", &ControlSample::error,
              "tracking error: norm of q - q_ref [rad or m], or distance of the tool from its reference [m]")
      .def_ro("bounded", &ControlSample::bounded, "True: a predicted force is at its bound, since the reference asks for more");
  nb::class_<ControlLoop>(
      m, "ControlLoop",
      R"(Simulates the arm of a control scenario tick by tick, as control() does in one call. Use it to interact with the arm while it runs.

After the last knot of the reference the arm stays there. Only one thread may use a loop at a time.

    >>> loop = st.ControlLoop(st.load_control_scenario("box_in_the_way"))
    >>> loop.push("arm/link_4", [0, 10, 0], [0, 0, 0])
    >>> samples = [loop.tick() for _ in range(10)]
    >>> round(samples[-1].time, 3), samples[-1].largest_force
    (0.045, 10.0))")
      .def(
          "__init__",
          [](ControlLoop* self, const ControlScenario& scenario) {
            const nb::gil_scoped_release unlocked;
            new (self) ControlLoop(scenario);
          },
          "scenario"_a)
      .def("tick", &tick,
           "Simulates one period: the controller receives the contacts, and its command is held. Returns a ControlSample. Raises "
           "InvalidInput: the simulation failed.")
      .def("push", &push, "link"_a, "force_W"_a, "p_LP"_a,
           R"(Applies a constant force to a link from the next tick on. It replaces the force of the previous call; a zero force ends it.

  link: as robot/link.
  force_W: force in W [N] (3).
  p_LP: point of application in the frame of the link [m] (3).)")
      .def_prop_ro(
          "time", [](const ControlLoop& self) { return self.loop.time(); }, "time of the next tick [s]")
      .def_prop_ro(
          "q", [](const ControlLoop& self) { return Eigen::VectorXd(self.loop.q()); }, "configuration (n_q)");
  def_no_pickle<ControlLoop>("ControlLoop", "the scenario that it was made from");
  def_pickle<ControlSample>();
}

/// @param scenario_of  the scenario that an argument means
template <class Scenario, class F>
void def_control(nb::module_& m, F scenario_of, const char* doc) {
  m.def(
      "control",
      [scenario_of](const Scenario& scenario, std::optional<Law> law, std::optional<double> lambda_max,
                    std::optional<double> friction_scale, std::optional<ContactSource> contacts, std::optional<double> delay,
                    std::optional<double> period, std::optional<std::uint64_t> seed, double settle, std::optional<double> timeout_s) {
        return run(scenario_of(scenario), {law, lambda_max, friction_scale, contacts, delay, period, seed}, settle, timeout_s);
      },
      "scenario"_a, nb::kw_only(), "law"_a = nb::none(), "lambda_max"_a = nb::none(), "friction_scale"_a = nb::none(),
      "contacts"_a = nb::none(), "delay"_a = nb::none(), "period"_a = nb::none(), "seed"_a = nb::none(),
      "settle"_a = execution::ControlRunOptions{}.settle, "timeout_s"_a = nb::none(), doc);
}

}  // namespace

void bind_control_run(nb::module_& m) {
  nb::enum_<ContactSource>(m, "ContactSource", "Source of the contacts that the controller receives.")
      .value("Simulated", ContactSource::True, "true contacts of the simulation, as if a tactile skin measured them")
      .value("Estimated", ContactSource::Estimated,
             "contacts that are estimated from joint torques, by a momentum observer and contact sensing");
  bind_scenario(m);
  bind_result(m);
  bind_loop(m);
  m.def("load_control_scenario", &load, "scenario"_a,
        "Loads a scenario for control(): the name of a built-in one, or a file. Raises InvalidInput: \"FILE:LINE: field: got …\"."
        R"(

    >>> st.load_control_scenario("box_in_the_way").lambda_max
    15.0)");
  m.def("load_control_scenario", &parse, "scenario"_a, nb::kw_only(), "base"_a = nb::none(),
        "Makes a scenario from a dict with the keys of a file. base: folder to which its paths are relative; None: the working folder. "
        "Raises "
        "InvalidInput: \"field: got …\".");
  def_control<ControlScenario>(
      m, [](const ControlScenario& scenario) { return scenario; },
      R"(Simulates a contact-aware controller: the robot tracks a reference that leads into obstacles, and keeps contact forces within bounds.

The second-order simulation contains impedance control of the joints and the ContactController above it.

  scenario: ControlScenario, or its name or file.
  law: control law.
  lambda_max: bound on contact forces [N], > 0.
  friction_scale: factor of every coefficient of friction of the simulation, >= 0.
  contacts: source of the contacts that the controller receives.
  delay: age of these contacts, rounded to whole ticks [s], >= 0.
  period: time between two commands [s], > 0.
  seed: of the noise of joint torques.
  settle: time after the start of a contact from which its force counts as steady [s], >= 0.
  timeout_s: largest wall time [s], > 0. None: no limit.

For the arguments from law to seed, None keeps the value of the scenario.

Returns a ControlRunResult. Its status is Solved; MaxIterations: the time was used up; or NumericalFailure: `message` gives the reason.
Raises InvalidInput.

    >>> run = st.control("box_in_the_way")
    >>> run.status, run.q.shape == (len(run.times), 7)
    (Status.Solved, True))");
  def_control<ScenarioFile>(m, &load, "The same for load_control_scenario(scenario): give the name or file of a scenario.");
  def_pickle<ControlScenario, ControlRunResult>();
}

}  // namespace stiction::python
