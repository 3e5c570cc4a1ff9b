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
  const Eigen::VectorXd full = configuration_of(sensor.model(), "q", q.value);
  sensing::ContactSetOptions options;
  options.sense.cone = sensing::FrictionCone(friction, rays);
  set_torques(sensor.model(), {noise, std::nullopt, rest, sign, unmeasured}, options.sense);
  options.sense.threshold = threshold;
  options.sense.tolerance = tolerance;
  options.max_contacts = max_contacts;
  options.starts = starts;
  options.descents = descents;
  const nb::gil_scoped_release unlocked;
  return sense_contacts(sensor, full, tau.value, base ? &*base : nullptr, last, options);
}

std::string to_text(const ContactSet& s) {
  std::string out;
  for (const SetContact& c : s.contacts) out += fmt::format("{}{} {:.3g} N", out.empty() ? "" : ", ", c.link, c.point.f_L.norm());
  return fmt::format("<stiction.ContactSet: {}; freedom {}>", out, s.freedom);
}

void bind_base_wrench(nb::module_& m) {
  const BaseWrench standard;
  nb::class_<BaseWrench>(m, "BaseWrench",
                         R"(What a force and moment sensor under the base of a robot measures of contacts.

  force_W: sum of the contact forces [N] (3). moment_W: sum of their moments about the origin of the world [N m] (3).
  force_noise, moment_noise: standard deviation of each component [N], [N m], > 0.)")
      .def(
          "__init__",
          [](BaseWrench* self, const Vector& force, const Vector& moment, double force_noise, double moment_noise) {
            new (self) BaseWrench{require_vector3("force_W", force), require_vector3("moment_W", moment), force_noise, moment_noise};
            self->validate();
          },
          "force_W"_a, "moment_W"_a, nb::kw_only(), "force_noise"_a = standard.force_noise, "moment_noise"_a = standard.moment_noise)
      .def_ro("force_W", &BaseWrench::force_W, "[N] (3)")
      .def_ro("moment_W", &BaseWrench::moment_W, "about the origin of the world [N m] (3)")
      .def_ro("force_noise", &BaseWrench::force_noise, "[N]")
      .def_ro("moment_noise", &BaseWrench::moment_noise, "[N m]");
  m.def(
      "calc_base_wrench",
      [](const Vector& p_W, const Vector& f_W) {
        return sensing::calc_base_wrench(require_vector3("p_W", p_W), require_vector3("f_W", f_W));
      },
      "p_W"_a, "f_W"_a, "That of a force at a point: f_W [N] (3) at p_W [m] (3).");
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
  nb::class_<SetContact>(m, "SetContact", "A contact of a set.")
      .def_ro("link", &SetContact::link, "as robot/link")
      .def_prop_ro(
          "p_L", [](const SetContact& c) { return c.point.p_L; }, "in the link's frame [m] (3)")
      .def_prop_ro(
          "n_L", [](const SetContact& c) { return c.point.n_L; }, "outward unit normal (3)")
      .def_prop_ro(
          "f_L", [](const SetContact& c) { return c.point.f_L; }, "on the robot [N] (3)")
      .def_ro("deviation", &SetContact::deviation,
              "standard deviation of the point; where torques say nothing of it the size of its link [m]")
      .def_ro("is_unique", &SetContact::is_unique, "no motion of the points and forces that leaves all torques moves this point");
  nb::class_<ContactSet>(m, "ContactSet", "Contacts that make the torques together.")
      .def_ro("contacts", &ContactSet::contacts, "by link")
      .def_ro("residual", &ContactSet::residual, "what they leave of the torques, squared (Y.9) [(N m)^2]")
      .def_ro("freedom", &ContactSet::freedom, "dimension of the points and forces near these with the same torques; 0: isolated")
      .def("__repr__", &to_text);
  nb::class_<ContactSets>(m, "ContactSets", "What one measurement says of contacts at the same time.")
      .def_prop_ro("verdict", [](const ContactSets& s) { return s.result.verdict; })
      .def_prop_ro(
          "count", [](const ContactSets& s) { return s.result.contacts; }, "contacts of each set: the fewest that explain the torques")
      .def_prop_ro(
          "ambiguous", [](const ContactSets& s) { return s.result.ambiguous; },
          "several combinations of links explain the torques, or points and forces can change together without a trace in them")
      .def_prop_ro("sets", &sets_of, "that explain the torques, by combination of links; where none do the best one")
      .def_prop_ro("best", &best_of, "the best set of each combination of links, the best combination first")
      .def_prop_ro(
          "explained", [](const ContactSets& s) { return s.result.explained; }, "what counts as explained [(N m)^2]")
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
             R"(One to three contacts at the same time that make the torques, the fewest that do.

  q: configuration (n_q), or joint positions alone (n_a) [rad or m]. tau: external torques (n_a) [N m; N].
  base: BaseWrench, or None. n_a torques cannot fix the 5 numbers of each contact if they are fewer: sets say their freedom.
  last: of the measurement before, or None. Where one of its sets, led down from where it was, explains these torques and fewer contacts do not,
    no other is looked for.
  max_contacts: in [1, 3]. starts: first contacts that are tried on each link, >= 1. descents: for each combination of links, >= 1.
  friction, rays, noise, threshold, tolerance, rest, sign, unmeasured: as of sense(); rays in [3, 64].

Raises InvalidInput by the name of the argument.)");
  def_pickle<BaseWrench, SetContact, ContactSet, ContactSets>();
}

}  // namespace stiction::python
