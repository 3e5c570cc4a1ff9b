#include <fmt/format.h>

#include "pickles.hpp"
#include "sensor.hpp"
#include "stiction/sensing/discriminate.hpp"

namespace stiction::python {
namespace {

using sensing::ContactPoint;

struct Candidate {
  std::string link;
  sensing::Candidate values;
  std::vector<ContactPoint> points;
};

std::vector<Candidate> candidates_of(const SenseResult& r) {
  std::vector<Candidate> out;
  for (const sensing::Candidate& c : r.result.candidates) {
    const auto first = r.result.points.begin() + c.first;
    out.push_back({r.sensor->link_name(c.best.link), c, {first, first + c.count}});
  }
  return out;
}

template <class F>
auto of_best(F field) {
  return [field](const Candidate& c) { return c.values.best.*field; };
}

template <class F>
auto of_values(F field) {
  return [field](const Candidate& c) { return c.values.*field; };
}

template <class F>
auto of_result(F field) {
  return [field](const SenseResult& r) { return r.result.*field; };
}

void bind_candidate(nb::module_& m) {
  nb::class_<Candidate>(m, "Candidate",
                        "A cluster of points that explain the torques alike, by its best one. A valley is one candidate with its extent.")
      .def_ro("link", &Candidate::link, "as robot/link")
      .def_prop_ro("p_L", of_best(&ContactPoint::p_L), "in the link's frame [m] (3)")
      .def_prop_ro("n_L", of_best(&ContactPoint::n_L), "outward unit normal (3)")
      .def_prop_ro("f_L", of_best(&ContactPoint::f_L), "on the robot [N] (3)")
      .def_prop_ro("p_W", of_values(&sensing::Candidate::p_W), "[m] (3)")
      .def_prop_ro("n_W", of_values(&sensing::Candidate::n_W), "(3)")
      .def_prop_ro("f_W", of_values(&sensing::Candidate::f_W), "[N] (3)")
      .def_prop_ro("residual", of_best(&ContactPoint::residual), "l (4.5) [(N m)^2]")
      .def_prop_ro("explains", of_values(&sensing::Candidate::explains), "the torques, as far as noise and tolerance tell")
      .def_prop_ro("objective", of_values(&sensing::Candidate::objective),
                   "min l + (noise/F)^2 |f|^2 at the best point [(N m)^2]; over noise^2 it is -2 ln of a posterior, up to a constant")
      .def_prop_ro("probability", of_values(&sensing::Candidate::probability),
                   "of the places on its link that are nearest to it; 0 without posterior=True")
      .def_prop_ro("rank", of_values(&sensing::Candidate::rank), "of J_C: below 3 the force is not unique")
      .def_prop_ro("extent", of_values(&sensing::Candidate::extent),
                   "largest distance of its points, of those as good, from the best one [m]")
      .def_prop_ro("force_spread", of_values(&sensing::Candidate::force_spread), "largest distance of their forces from f_W [N]")
      .def_prop_ro(
          "points", [](const Candidate& c) { return rows(c.points, 3, [](const ContactPoint& p) { return p.p_L; }); },
          "p_L of its points, by residual [m] (points, 3)")
      .def_prop_ro(
          "residuals", [](const Candidate& c) { return vector_of(c.points, [](const ContactPoint& p) { return p.residual; }); },
          "l of its points [(N m)^2] (points)")
      .def("__repr__", [](const Candidate& c) {
        const Eigen::Vector3d& p = c.values.p_W;
        return fmt::format("Candidate({}{}, p_W=[{:.3f}, {:.3f}, {:.3f}], {:.3g} N, residual={:.2g}, extent={:.3f})", c.link,
                           c.values.explains ? "" : ", does not explain", p.x(), p.y(), p.z(), c.values.f_W.norm(), c.values.best.residual,
                           c.values.extent);
      });
}

/// Probabilities with the names of links.
struct Posterior {
  SensorPtr sensor;
  sensing::Posterior values;
};

std::optional<Posterior> posterior_of(const SenseResult& r) {
  if (r.result.posterior.links.empty()) return std::nullopt;
  return Posterior{r.sensor, r.result.posterior};
}

std::vector<std::string> credible_of(const Posterior& p) {
  std::vector<std::string> out;
  for (const int link : p.values.credible) out.push_back(p.sensor->link_name(link));
  return out;
}

nb::dict links_of(const Posterior& p) {
  std::vector<int> order(p.values.links.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const auto of = [&](int link) { return p.values.links[static_cast<std::size_t>(link)]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return of(a) > of(b); });
  nb::dict out;
  for (const int link : order) out[p.sensor->link_name(link).c_str()] = of(link);
  return out;
}

/// Places of a link: their points, or their probabilities.
std::vector<sensing::TouchedPlace> places_of(const Posterior& p, const std::string& link) {
  const int index = p.sensor->link_index(link);
  std::vector<sensing::TouchedPlace> out;
  for (const sensing::TouchedPlace& place : p.values.places)
    if (place.link == index) out.push_back(place);
  return out;
}

void bind_posterior(nb::module_& m) {
  nb::class_<Posterior>(m, "Posterior", R"(Where the robot is touched, as probabilities: nothing, or one contact on a link.

Before torques are seen a contact has the probability touch_prior, and acts anywhere on what can be touched, uniformly by area, with a force that is normal in every
direction and cut to the friction cone. Its standard deviation is plausible_force, or not known: 4 N, what the weakest joint holds, or their geometric mean.)")
      .def_prop_ro(
          "nothing", [](const Posterior& p) { return p.values.nothing; }, "probability that nothing touches the robot")
      .def_prop_ro("links", &links_of, nb::sig("def links(self) -> dict[str, float]"),
                   "probability of a contact on each link, the largest first; with `nothing` they sum to 1")
      .def_prop_ro("credible", &credible_of, "the fewest links that hold 95 % of what is not `nothing`, the likeliest first")
      .def(
          "points",
          [](const Posterior& p, const std::string& link) {
            const auto places = places_of(p, link);
            return rows(places, 3, [&](const sensing::TouchedPlace& place) {
              return p.sensor->links()[static_cast<std::size_t>(place.link)].batch.p_L(place.sample);
            });
          },
          "link"_a, "places on a link that carry weight, the likeliest first, in its frame [m] (places, 3)")
      .def(
          "probabilities",
          [](const Posterior& p, const std::string& link) {
            return vector_of(places_of(p, link), [](const sensing::TouchedPlace& place) { return place.probability; });
          },
          "link"_a, "their probabilities (places)")
      .def("__repr__", [](const Posterior& p) {
        std::string text = fmt::format("nothing {:.2g}", p.values.nothing);
        for (const int link : p.values.credible)
          text += fmt::format(", {} {:.2g}", p.sensor->link_name(link), p.values.links[static_cast<std::size_t>(link)]);
        return fmt::format("<stiction.Posterior: {}>", text);
      });
}

double calc_distance(const SenseResult& r, const std::string& link, const Vector& p_L) {
  const sensing::ContactPoint contact{.link = r.sensor->link_index(link), .p_L = require_vector3("p_L", p_L)};
  double out = std::numeric_limits<double>::infinity();
  for (const sensing::Candidate& c : r.result.candidates)
    if (c.explains) out = std::min(out, sensing::calc_distance(r.result, c, contact));
  return out;
}

sensing::Discrimination discriminate(const SenseResult& r, const Vector& q, Flag all, double joint_step, std::optional<double> travel,
                                     double least, double sideways) {
  const Eigen::VectorXd full = configuration_of(r.sensor->model(), "q", q.value);
  std::vector<sensing::Candidate> candidates;
  for (const sensing::Candidate& c : r.result.candidates)
    if (all || c.explains) candidates.push_back(c);
  sensing::Discrimination out;
  const nb::gil_scoped_release unlocked;
  (void)sensing::discriminate(*r.sensor, full, candidates, {joint_step, travel, least, sideways}, out);
  return out;
}

void bind_discrimination(nb::module_& m) {
  using sensing::Discrimination;
  nb::class_<Discrimination>(m, "Discrimination", "A small motion that tells candidates apart (4.13).")
      .def_ro("status", &Discrimination::status, "Solved, or Infeasible: proved that no motion does")
      .def_ro("dq", &Discrimination::dq, "of the joints (n_a) [rad or m]")
      .def_ro("pull", &Discrimination::pull, "of each candidate: 1 it pulls away, 0 it pushes into")
      .def_ro("objective", &Discrimination::objective,
              "how far from half of the candidates it pulls away, of those that are possible the least")
      .def_ro("nodes", &Discrimination::nodes, "linear programs that were solved")
      .def("__repr__", [](const Discrimination& d) {
        return fmt::format("<stiction.Discrimination: {}, {} candidates>", core::to_string(d.status), d.pull.size());
      });
}

void bind_sensed_link(nb::module_& m) {
  using Link = SensedLink;
  nb::class_<Link>(m, "SensedLink", "A link on which contacts are looked for.")
      .def_prop_ro(
          "name", [](const Link& l) { return l.sensor->link_name(l.index); }, "as robot/link")
      .def_prop_ro(
          "p_L", [](const Link& l) { return Rows(l.get().batch.rows.topRows(3).leftCols(l.get().batch.size).transpose()); },
          "samples, in the link's frame [m] (samples, 3)")
      .def_prop_ro(
          "n_L", [](const Link& l) { return Rows(-l.get().batch.rows.middleRows(3, 3).leftCols(l.get().batch.size).transpose()); },
          "their outward unit normals (samples, 3)")
      .def_prop_ro(
          "spacing", [](const Link& l) { return l.get().spacing; }, "root of the area per sample [m]")
      .def_prop_ro(
          "joints", [](const Link& l) { return l.get().joints; },
          "coordinates that move it: below 3 forces are not unique, below 5 points are not")
      .def_prop_ro(
          "area", [](const Link& l) { return l.get().surface.area; }, "of its surface [m^2]")
      .def_prop_ro(
          "size", [](const Link& l) { return l.get().surface.size; }, "diagonal of its bounding box [m]")
      .def("__repr__", [](const Link& l) {
        return fmt::format("<stiction.SensedLink '{}': {} samples, {} joints>", l.sensor->link_name(l.index), l.get().batch.size,
                           l.get().joints);
      });
}

}  // namespace

void bind_sense_results(nb::module_& m) {
  using sensing::Verdict;
  nb::enum_<Verdict>(m, "Verdict", "What torques say of contacts.")
      .value("BelowThreshold", Verdict::BelowThreshold, "no contact, or one that these torques do not show")
      .value("Explained", Verdict::Explained, "at least one candidate makes the torques, as far as noise and tolerance tell")
      .value("Unexplained", Verdict::Unexplained,
             "a single contact on the sensed links does not: several contacts, another link, or a wrong friction");
  bind_sensed_link(m);
  bind_candidate(m);
  bind_discrimination(m);
  bind_posterior(m);
  const sensing::DiscriminationOptions discrimination;
  using Result = sensing::SenseResult;
  nb::class_<SenseResult>(m, "SenseResult", "What torques say of one moment.")
      .def_prop_ro("verdict", of_result(&Result::verdict))
      .def_prop_ro("candidates", &candidates_of, "those that explain, by objective, then the others, by residual")
      .def_prop_ro("explained", of_result(&Result::explained), "l up to which torques count as explained [(N m)^2]")
      .def_prop_ro("posterior", &posterior_of, "Posterior, or None without posterior=True")
      .def_prop_ro(
          "largest", [](const SenseResult& r) { return r.result.largest.torque; },
          "of the torques that is largest against its noise, less rest [N m; N]")
      .def_prop_ro(
          "largest_joint", [](const SenseResult& r) { return r.result.largest.joint; }, "its joint")
      .def_prop_ro("threshold", of_result(&Result::threshold), "from which that joint would have shown a contact [N m; N]")
      .def_prop_ro("noise", of_result(&Result::noise),
                   "of each torque in the coordinates of residuals, so that residual/noise^2 has no unit [N m]")
      .def_prop_ro("friction", of_result(&Result::friction),
                   "with which they were looked for: more than was given where that explained nothing")
      .def_prop_ro("samples", of_result(&Result::samples))
      .def_prop_ro("accepted", of_result(&Result::accepted), "samples with a residual small enough")
      .def_prop_ro("descents", of_result(&Result::descents))
      .def_prop_ro("converged", of_result(&Result::converged), "of the descents")
      .def("calc_distance", &calc_distance, "link"_a, "p_L"_a,
           "Distance of a known contact, p_L in the frame of a link [m] (3), from the nearest point that explains the torques [m]; inf "
           "where "
           "none is on that link.")
      .def("discriminate", &discriminate, "q"_a, nb::kw_only(), "all"_a = false, "joint_step"_a = discrimination.joint_step,
           "travel"_a = nb::none(), "least"_a = discrimination.least, "sideways"_a = discrimination.sideways,
           R"(The motion that pulls away from half of the candidates and pushes into the others, as nearly as can be (4.13): what becomes
of the torques then refutes one half. Of those that explain, in their order; with `all` of all.

  q: (n_q), or joint positions (n_a), of the measurement.
  joint_step: largest change of a joint [rad or m], > 0.
  travel: longest motion at a contact [m], > 0; None: a tenth of joint_step times the longest reach.
  least: of pulling and pushing, sideways: of sliding, shares of travel; least in (0, 1).

Raises InvalidInput: options, no candidate.)")
      .def("__repr__", [](const SenseResult& r) {
        return fmt::format("<stiction.SenseResult: {}, {} candidates>", sensing::to_string(r.result.verdict), r.result.candidates.size());
      });
  def_pickle<Candidate, sensing::Discrimination, SensedLink, SenseResult, Posterior>();
}

}  // namespace stiction::python
