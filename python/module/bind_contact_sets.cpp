#include <fmt/format.h>

#include "pickles.hpp"
#include "sensor.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/contact_sets.hpp"
#include "torque_arguments.hpp"

namespace stiction::python {
namespace {

using sensing::BaseWrench;

struct SetContact {
  std::string link;
  sensing::ContactPoint point;
  double deviation;
  bool is_unique;
};

struct ContactSet {
  std::vector<SetContact> contacts;
  double residual;
  int freedom;
};

ContactSet make_set(const ContactSets& all, const sensing::ContactSet& s) {
  ContactSet out{{}, s.residual, s.freedom};
  for (std::size_t i = 0; i < static_cast<std::size_t>(s.count); ++i)
    out.contacts.push_back({all.sensor->link_name(s.contacts[i].link), s.contacts[i], s.deviation[i], s.point_is_unique[i]});
  return out;
}

std::vector<ContactSet> sets_of(const ContactSets& all) {
  std::vector<ContactSet> out;
  for (const sensing::ContactSet& s : all.result.sets) out.push_back(make_set(all, s));
  return out;
}

std::vector<ContactSet> best_of(const ContactSets& all) {
  std::vector<ContactSet> out;
  for (const sensing::ContactGroup& g : all.result.groups) out.push_back(make_set(all, all.result.sets[static_cast<std::size_t>(g.first)]));
  return out;
}

ContactSets sense_with_options(const Sensor& sensor, const Vector& q, const Vector& tau, const std::optional<BaseWrench>& base,
                               const ContactSets* last, int max_contacts, double friction, int rays, const NoiseArgument& noise,
                               std::optional<double> threshold, double tolerance, int starts, int descents,
                               const std::optional<RestArgument>& rest, int sign, const std::vector<JointArgument>& unmeasured) {
  const Eigen::VectorXd full = configuration_of(sensor.model(), "q", q.named("q"));
  sensing::ContactSetOptions options;
  options.sense.cone = sensing::FrictionCone(friction, rays);
  set_torques(sensor.model(), {noise, std::nullopt, rest, sign, unmeasured}, options.sense);
  options.sense.threshold = threshold;
  options.sense.tolerance = tolerance;
  options.max_contacts = max_contacts;
  options.starts = starts;
  options.descents = descents;
  const nb::gil_scoped_release unlocked;
  return sense_contacts(sensor, full, tau.named("tau"), base ? &*base : nullptr, last, options);
}

std::string to_text(const ContactSet& s) {
  std::string out;
  for (const SetContact& c : s.contacts) out += fmt::format("{}{} {:.3g} N", out.empty() ? "" : ", ", c.link, c.point.f_L.norm());
  return fmt::format("<stiction.ContactSet: {}; freedom {}>", out, s.freedom);
}

void bind_base_wrench(nb::module_& m) {
  const BaseWrench standard;
  nb::class_<BaseWrench>(m, "BaseWrench",
                         R"(Measurement of a force and moment sensor under the base of a robot.

  force_W: sum of the contact forces in W [N] (3).
  moment_W: sum of their moments about the origin of W [N m] (3).
  force_noise, moment_noise: standard deviation of each component [N], [N m], > 0.)")
      .def(
          "__init__",
          [](BaseWrench* self, const Vector& force, const Vector& moment, double force_noise, double moment_noise) {
            new (self) BaseWrench{require_vector3("force_W", force), require_vector3("moment_W", moment), force_noise, moment_noise};
            self->validate();
          },
          "force_W"_a, "moment_W"_a, nb::kw_only(), "force_noise"_a = standard.force_noise, "moment_noise"_a = standard.moment_noise)
      .def_ro("force_W", &BaseWrench::force_W, "sum of the contact forces in W [N] (3)")
      .def_ro("moment_W", &BaseWrench::moment_W, "sum of the moments about the origin of W [N m] (3)")
      .def_ro("force_noise", &BaseWrench::force_noise, "standard deviation of each force component [N]")
      .def_ro("moment_noise", &BaseWrench::moment_noise, "standard deviation of each moment component [N m]");
  m.def(
      "calc_base_wrench",
      [](const Vector& p_W, const Vector& f_W) {
        return sensing::calc_base_wrench(require_vector3("p_W", p_W), require_vector3("f_W", f_W));
      },
      "p_W"_a, "f_W"_a, "Returns the BaseWrench of a single contact force f_W [N] (3) at the point p_W [m] (3).");
}

}  // namespace

ContactSets sense_contacts(const Sensor& sensor, const Eigen::VectorXd& q, const Eigen::VectorXd& tau, const BaseWrench* base,
                           const ContactSets* last, const sensing::ContactSetOptions& options) {
  if (last != nullptr && last->sensor != sensor.ptr()) core::throw_invalid("last", "a result of another sensor", "one of this sensor");
  ContactSets out{sensor.ptr(), {}};
  sensing::ContactSetWorkspace work(sensor.ptr());
  sensing::sense_contacts(sensor.get(), {q, tau, base, last != nullptr ? &last->result.sets : nullptr}, options, work, out.result);
  return out;
}

void bind_contact_sets(nb::module_& m, nb::class_<Sensor>& sensor) {
  bind_base_wrench(m);
  nb::class_<SetContact>(m, "SetContact", "One contact of a ContactSet.")
      .def_ro("link", &SetContact::link, "link in contact, as robot/link")
      .def_prop_ro(
          "p_L", [](const SetContact& c) { return c.point.p_L; }, "contact point in the frame of the link [m] (3)")
      .def_prop_ro(
          "n_L", [](const SetContact& c) { return c.point.n_L; }, "outward unit normal in the frame of the link (3)")
      .def_prop_ro(
          "f_L", [](const SetContact& c) { return c.point.f_L; }, "force on the robot in the frame of the link [N] (3)")
      .def_ro("deviation", &SetContact::deviation,
              "standard deviation of the point [m]; the size of the link if the torques do not determine the point")
      .def_ro("is_unique", &SetContact::is_unique, "True: no change of points and forces that keeps all torques moves this point");
  nb::class_<ContactSet>(m, "ContactSet", "Simultaneous contacts that together explain the torques.")
      .def_ro("contacts", &ContactSet::contacts, "contacts, ordered by link")
      .def_ro("residual", &ContactSet::residual, "squared torques that the contacts leave unexplained (Y.9) [(N m)^2]")
      .def_ro("freedom", &ContactSet::freedom,
              "dimension of the nearby points and forces with the same torques; 0: the solution is isolated")
      .def("__repr__", &to_text);
  nb::class_<ContactSets>(m, "ContactSets", "Sets of simultaneous contacts that explain one measurement.")
      .def_prop_ro(
          "verdict", [](const ContactSets& s) { return s.result.verdict; }, "whether contacts explain the torques")
      .def_prop_ro(
          "count", [](const ContactSets& s) { return s.result.contacts; },
          "number of contacts in each set: the smallest number that explains the torques")
      .def_prop_ro(
          "ambiguous", [](const ContactSets& s) { return s.result.ambiguous; },
          "True: several combinations of links explain the torques, or points and forces can change together without a change of the "
          "torques")
      .def_prop_ro("sets", &sets_of, "sets that explain the torques, ordered by combination of links; if no set does, the best one")
      .def_prop_ro("best", &best_of, "the best set of each combination of links, the best combination first")
      .def_prop_ro(
          "explained", [](const ContactSets& s) { return s.result.explained; }, "largest residual that counts as explained [(N m)^2]")
      .def("__repr__", [](const ContactSets& s) {
        return fmt::format("<stiction.ContactSets: {}, {} contacts, {} sets{}>", sensing::to_string(s.result.verdict), s.result.contacts,
                           s.result.sets.size(), s.result.ambiguous ? ", ambiguous" : "");
      });
  const sensing::ContactSetOptions standard;
  sensor.def("sense_contacts", &sense_with_options, "q"_a, "tau"_a, "base"_a = nb::none(), "last"_a.none() = nb::none(), nb::kw_only(),
             "max_contacts"_a = standard.max_contacts, "friction"_a = standard.sense.cone.friction(), "rays"_a = standard.sense.cone.rays(),
             "noise"_a = standard.sense.noise, "threshold"_a = nb::none(), "tolerance"_a = standard.sense.tolerance,
             "starts"_a = standard.starts, "descents"_a = standard.descents, "rest"_a = nb::none(), "sign"_a = 1,
             "unmeasured"_a = std::vector<JointArgument>(),
             R"(Finds one to three simultaneous contacts that explain the torques of one measurement, with as few contacts as possible.

Each contact has 5 unknown numbers. If there are fewer torques than unknowns, the contacts are not unique: see ContactSet.freedom.

  q: configuration (n_q), or joint positions alone (n_a) [rad or m].
  tau: external torques (n_a) [N m; N].
  base: BaseWrench of a sensor under the base, or None.
  last: ContactSets of the previous measurement, or None. If one of its sets, improved by descent, explains these torques, and fewer
    contacts do not, the search ends there.
  max_contacts: largest number of contacts, in [1, 3].
  starts: number of first contacts that are tried on each link, >= 1.
  descents: number of descents for each combination of links, >= 1.
  friction, rays, noise, threshold, tolerance, rest, sign, unmeasured: as in sense(); rays in [3, 64].

Returns ContactSets. Raises InvalidInput, which names the argument.)");
  def_pickle<BaseWrench, SetContact, ContactSet, ContactSets>();
}

}  // namespace stiction::python
