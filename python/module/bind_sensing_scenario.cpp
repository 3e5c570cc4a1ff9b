#include <fmt/format.h>

#include "pickles.hpp"
#include "scenario_file.hpp"
#include "sensor.hpp"
#include "stiction/execution/contact_control/poke.hpp"
#include "stiction/sensing/residual_map.hpp"
#include "stiction/tasks/sensing_scenario_file.hpp"
#include "watcher.hpp"
#include "yaml_text.hpp"

namespace stiction::python {
namespace {

/// A scenario with its sensor, made once.
struct Scenario {
  sensing::Scenario values;
  std::shared_ptr<Sensor> sensor;
};

struct KnownContact {
  std::string link;
  Eigen::Vector3d p_L, f_L;
};

Scenario with_sensor(sensing::Scenario&& scenario) {
  if (std::string message; execution::simulate_poke(scenario, message) != core::Status::Solved)
    core::throw_invalid("poke", "a simulation that broke down: " + message, "one that runs");
  auto sensor = std::make_shared<Sensor>(scenario.sensor);
  return {std::move(scenario), std::move(sensor)};
}

Scenario load(const ScenarioFile& scenario) {
  const auto file = file_of(scenario);
  const nb::gil_scoped_release unlocked;
  return with_sensor(tasks::load_sensing_scenario(file, tasks::default_package_dirs()));
}

Scenario parse(const nb::dict& scenario, const std::optional<std::filesystem::path>& base) {
  const std::string text = yaml_text(scenario);
  const auto folder = folder_of(base);
  const nb::gil_scoped_release unlocked;
  return with_sensor(tasks::parse_sensing_scenario(text, folder, tasks::default_package_dirs()));
}

std::vector<KnownContact> contacts_of(const Scenario& s) {
  std::vector<KnownContact> out;
  for (const sensing::ContactPoint& c : s.values.contacts) out.push_back({s.values.sensor->link_name(c.link), c.p_L, c.f_L});
  return out;
}

std::optional<KnownContact> contact_of(const Scenario& s) {
  const auto all = contacts_of(s);
  return all.size() == 1 ? std::optional(all[0]) : std::nullopt;
}

std::vector<SenseResult> sense_scenario(Scenario& scenario) {
  const sensing::Series& series = scenario.values.series;
  Interrupt interrupt;
  std::vector<SenseResult> out;
  {
    const nb::gil_scoped_release unlocked;
    out = sense_series(*scenario.sensor, series.q, series.tau, scenario.values.options, interrupt.control({}), series.gaps);
  }
  interrupt.rethrow();
  return out;
}

SenseResult sense_moment(Scenario& scenario, const Vector& q, const Vector& tau, const SenseResult* last) {
  const Eigen::VectorXd full = configuration_of(scenario.sensor->model(), "q", q.named("q"));
  const nb::gil_scoped_release unlocked;
  return sense(*scenario.sensor, full, tau.named("tau"), last, scenario.values.options);
}

ContactSets sense_contacts_moment(Scenario& scenario, const Vector& q, const Vector& tau, const std::optional<sensing::BaseWrench>& base,
                                  const ContactSets* last) {
  const Eigen::VectorXd full = configuration_of(scenario.sensor->model(), "q", q.named("q"));
  const nb::gil_scoped_release unlocked;
  return sense_contacts(*scenario.sensor, full, tau.named("tau"), base ? &*base : nullptr, last, scenario.values.set_options());
}

/// Of the samples of each link.
std::vector<Eigen::VectorXd> calc_residual_shares(const Scenario& scenario, const Vector& q, const Vector& tau, double friction) {
  const sensing::SenseOptions& options = scenario.values.options;
  const sensing::FrictionCone cone(friction, options.cone.is_lorentz() ? 0 : options.cone.rays());
  const Eigen::VectorXd full = configuration_of(scenario.sensor->model(), "q", q.named("q"));
  core::require_size("tau", tau.named("tau").size(), scenario.sensor->model().n_a());
  sensing::WhitenedTorques whitened;
  whitened.assign(options.torques, tau.value, options.noise, options.tolerance);
  const double size = whitened.tau().norm();
  std::vector<Eigen::VectorXd> out = sensing::calc_residual_map(*scenario.values.sensor, full, tau.value, cone, &whitened);
  for (Eigen::VectorXd& link : out)
    link = size > 0 ? Eigen::VectorXd((link.cwiseMax(0).cwiseSqrt() / size).cwiseMin(1)) : Eigen::VectorXd::Ones(link.size());
  return out;
}

std::variant<double, Eigen::MatrixXd> noise_of(const Scenario& s) {
  const sensing::SenseOptions& options = s.values.options;
  if (options.torques.covariance.size() == 0) return options.noise;
  return options.torques.covariance;
}

Eigen::VectorXd rest_of(const Scenario& s) {
  const Eigen::VectorXd& rest = s.values.options.torques.rest;
  return rest.size() == 0 ? Eigen::VectorXd::Zero(s.sensor->model().n_a()) : rest;
}

std::vector<sensing::BaseWrench> base_wrenches(const Scenario& s) {
  if (!s.values.series.base.empty() || !s.values.base) return s.values.series.base;
  return {*s.values.base};
}

std::vector<SenseResult> sense_file(const ScenarioFile& file) {
  Scenario scenario = load(file);
  return sense_scenario(scenario);
}

}  // namespace

void bind_sensing_scenario(nb::module_& m) {
  nb::class_<KnownContact>(m, "KnownContact", "Contact from which the torques of a scenario were computed.")
      .def_ro("link", &KnownContact::link, "link in contact, as robot/link")
      .def_ro("p_L", &KnownContact::p_L, "contact point in the frame of the link [m] (3)")
      .def_ro("f_L", &KnownContact::f_L, "force on the robot in the frame of the link [N] (3)")
      .def("__repr__", [](const KnownContact& c) {
        return fmt::format("KnownContact({}, p_L=[{:.3f}, {:.3f}, {:.3f}], {:.3g} N)", c.link, c.p_L.x(), c.p_L.y(), c.p_L.z(),
                           c.f_L.norm());
      });
  nb::class_<Scenario>(m, "SensingScenario",
                       "Scenario for sense(): a robot and its measured joint torques (tasks/schema/sensing.schema.json).")
      .def_prop_ro(
          "name", [](const Scenario& s) { return s.values.name; }, "name of the scenario")
      .def_prop_ro(
          "description", [](const Scenario& s) { return s.values.description; }, "one line about the scenario")
      .def_prop_ro(
          "file", [](const Scenario& s) { return s.values.file; }, "path of the scenario file")
      .def_ro("sensor", &Scenario::sensor, "sensor of the robot")
      .def_prop_ro(
          "times", [](const Scenario& s) { return vector_of(s.values.series.times); }, "times of the measurements [s] (time)")
      .def_prop_ro(
          "q", [](const Scenario& s) { return rows(s.values.series.q); }, "joint positions [rad or m] (time, n_a)")
      .def_prop_ro(
          "tau", [](const Scenario& s) { return rows(s.values.series.tau); }, "torques as measured [N m; N] (time, n_a)")
      .def_prop_ro(
          "notes", [](const Scenario& s) { return s.values.series.notes; },
          "remarks on the data file, one sentence each: columns that were not read, or that need an explanation")
      .def_prop_ro(
          "pushed", [](const Scenario& s) { return s.values.series.pushed; },
          "for a simulated robot, the indices into `contacts` of the pushes that act at each time (time); otherwise empty")
      .def_prop_ro("contact", &contact_of, "contact of the file, if it gives a single contact instead of torques; otherwise None")
      .def_prop_ro("contacts", &contacts_of, "contacts of the file, if it gives contacts instead of torques")
      .def_prop_ro("noise", &noise_of, "standard deviation of each torque [N m], or the covariance of all (n_a, n_a)")
      .def_prop_ro("rest", &rest_of, "torques without contact, which are subtracted from `tau` (n_a) [N m; N]")
      .def_prop_ro(
          "sign", [](const Scenario& s) { return s.values.options.torques.sign; },
          "-1: `tau` are torques of the robot on its surroundings; otherwise 1. External torques are sign (tau - rest)")
      .def("calc_residual_shares", &calc_residual_shares, "q"_a, "tau"_a, "friction"_a,
           R"(Computes which share of the torques the best single force at a sample leaves unexplained, with the options of the scenario.

  q: configuration (n_q), or joint positions alone (n_a) [rad or m].
  tau: torques as in `tau` of the scenario (n_a) [N m; N].
  friction: friction coefficient.

Returns sqrt(l)/|tau| with the residual l of (4.5) at the samples of each link of the sensor, in [0, 1]; 1 where the torques are 0. Torques
are relative to their noise if it differs between joints. Raises InvalidInput: wrong sizes, numbers that are not finite.)")
      .def("sense", &sense_moment, "q"_a, "tau"_a, "last"_a.none() = nb::none(),
           R"(Finds the single contacts that explain one measurement, as Sensor.sense() does, with the options of the scenario.

  q: configuration (n_q), or joint positions alone (n_a) [rad or m].
  tau: torques as in `tau` of the scenario (n_a) [N m; N].
  last: SenseResult of the previous measurement, or None.

Returns a SenseResult. Raises InvalidInput: wrong sizes, numbers that are not finite.)")
      .def_prop_ro(
          "max_contacts", [](const Scenario& s) { return s.values.max_contacts; }, "largest number of simultaneous contacts")
      .def_prop_ro(
          "base_wrench", [](const Scenario& s) { return s.values.base; },
          "measured force and moment under the base, or None; for a simulated robot only the noise of the sensor")
      .def_prop_ro("base_wrenches", &base_wrenches, "measured forces and moments under the base (time); empty: none")
      .def("sense_contacts", &sense_contacts_moment, "q"_a, "tau"_a, "base"_a = nb::none(), "last"_a.none() = nb::none(),
           R"(Finds simultaneous contacts that explain one measurement, as Sensor.sense_contacts() does, with the options of the scenario.

  q: configuration (n_q), or joint positions alone (n_a) [rad or m].
  tau: torques as in `tau` of the scenario (n_a) [N m; N].
  base: BaseWrench, or None.
  last: ContactSets of the previous measurement, or None.

Returns ContactSets with at most max_contacts contacts. Raises InvalidInput: wrong sizes, numbers that are not finite.)")
      .def("__repr__", [](const Scenario& s) {
        return fmt::format("<stiction.SensingScenario '{}': {} moments>", s.values.name, s.values.series.times.size());
      });
  m.def("load_sensing_scenario", &load, "scenario"_a,
        "Loads a scenario for sense(): the name of a built-in one, or a file. Raises InvalidInput: \"FILE:LINE: field: got …\"."
        R"(

    >>> scenario = st.load_sensing_scenario("ur5_forearm")
    >>> scenario.tau.shape, scenario.contact.link
    ((1, 6), 'arm/forearm_link'))");
  m.def("load_sensing_scenario", &parse, "scenario"_a, nb::kw_only(), "base"_a = nb::none(),
        "Makes a scenario from a dict with the keys of a file. base: folder to which its paths are relative; None: the working folder. "
        "Raises "
        "InvalidInput: \"field: got …\".");
  m.def("sense", &sense_scenario, "scenario"_a,
        R"(Locates contacts on a robot from its joint torques, for every measurement of a scenario.

For your own robot, make a Sensor and call its method sense().

  scenario: SensingScenario, or its name or file. Its options are used.

Returns a list with one SenseResult for each measurement. Each search also starts from the candidates of the previous measurement.

    >>> [result.verdict for result in st.sense("ur5_forearm")]
    [Verdict.Explained])");
  m.def("sense", &sense_file, "scenario"_a, "The same for load_sensing_scenario(scenario): give the name or file of a scenario.");
  def_pickle<KnownContact, Scenario>();
}

}  // namespace stiction::python
