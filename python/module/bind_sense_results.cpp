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
                        "Possible contact: a cluster of points that explain the torques equally well, described by its best point.")
      .def_ro("link", &Candidate::link, "link in contact, as robot/link")
      .def_prop_ro("p_L", of_best(&ContactPoint::p_L), "contact point in the frame of the link [m] (3)")
      .def_prop_ro("n_L", of_best(&ContactPoint::n_L), "outward unit normal in the frame of the link (3)")
      .def_prop_ro("f_L", of_best(&ContactPoint::f_L), "force on the robot in the frame of the link [N] (3)")
      .def_prop_ro("p_W", of_values(&sensing::Candidate::p_W), "contact point in W [m] (3)")
      .def_prop_ro("n_W", of_values(&sensing::Candidate::n_W), "outward unit normal in W (3)")
      .def_prop_ro("f_W", of_values(&sensing::Candidate::f_W), "force on the robot in W [N] (3)")
      .def_prop_ro("residual", of_best(&ContactPoint::residual), "residual l (4.5) [(N m)^2]")
      .def_prop_ro("explains", of_values(&sensing::Candidate::explains),
                   "True: the contact explains the torques within noise and tolerance")
      .def_prop_ro("objective", of_values(&sensing::Candidate::objective),
                   "min l + (noise/F)^2 |f|^2 at the best point [(N m)^2]; divided by noise^2 it is -2 ln of a posterior, up to a constant")
      .def_prop_ro("probability", of_values(&sensing::Candidate::probability),
                   "probability of the points of its link that are nearest to this candidate; 0 without posterior=True")
      .def_prop_ro("rank", of_values(&sensing::Candidate::rank), "rank of J_C; below 3 the force is not unique")
      .def_prop_ro("extent", of_values(&sensing::Candidate::extent),
                   "size of the cluster: largest distance of an equally good point from the best point [m]")
      .def_prop_ro("force_spread", of_values(&sensing::Candidate::force_spread),
                   "largest difference between the forces of these points and f_W [N]")
      .def_prop_ro(
          "points", [](const Candidate& c) { return rows(c.points, 3, [](const ContactPoint& p) { return p.p_L; }); },
          "p_L of the points of the cluster, ordered by residual [m] (points, 3)")
      .def_prop_ro(
          "residuals", [](const Candidate& c) { return vector_of(c.points, [](const ContactPoint& p) { return p.residual; }); },
          "residuals l of these points [(N m)^2] (points)")
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
  nb::class_<Posterior>(m, "Posterior", R"(Probabilities of where the robot is touched: nowhere, or at one contact on a link.

The prior probability of a contact is touch_prior. The prior of the contact point is uniform over the sensed surface. The prior of the force
is a normal distribution, cut to the friction cone, with the standard deviation plausible_force. If plausible_force is not given, the
standard deviation is unknown: 4 N, the force that the weakest joint holds, or their geometric mean.)")
      .def_prop_ro(
          "nothing", [](const Posterior& p) { return p.values.nothing; }, "probability that nothing touches the robot")
      .def_prop_ro("links", &links_of, nb::sig("def links(self) -> dict[str, float]"),
                   "probability of a contact on each link, the largest first; together with `nothing` they sum to 1")
      .def_prop_ro("credible", &credible_of, "smallest set of links with 95 % of the probability of a contact, the most likely link first")
      .def(
          "points",
          [](const Posterior& p, const std::string& link) {
            const auto places = places_of(p, link);
            return rows(places, 3, [&](const sensing::TouchedPlace& place) {
              return p.sensor->links()[static_cast<std::size_t>(place.link)].batch.p_L(place.sample);
            });
          },
          "link"_a,
          "Returns the points of a link with notable probability, the most likely first, in the frame of the link [m] (places, 3).")
      .def(
          "probabilities",
          [](const Posterior& p, const std::string& link) {
            return vector_of(places_of(p, link), [](const sensing::TouchedPlace& place) { return place.probability; });
          },
          "link"_a, "Returns the probabilities of the points of a link that points() returns (places).")
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
  const Eigen::VectorXd full = configuration_of(r.sensor->model(), "q", q.named("q"));
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
  nb::class_<Discrimination>(m, "Discrimination", "Small motion of the robot that distinguishes candidates (4.13).")
      .def_ro("status", &Discrimination::status, "Solved; or Infeasible: proof that no motion distinguishes the candidates")
      .def_ro("dq", &Discrimination::dq, "motion of the joints (n_a) [rad or m]")
      .def_ro("pull", &Discrimination::pull, "for each candidate, 1: the motion pulls away from the contact; 0: it pushes into the contact")
      .def_ro("objective", &Discrimination::objective,
              "difference between the number of candidates that it pulls away from and half of all; the smallest possible value")
      .def_ro("nodes", &Discrimination::nodes, "number of linear programs that were solved")
      .def("__repr__", [](const Discrimination& d) {
        return fmt::format("<stiction.Discrimination: {}, {} candidates>", core::to_string(d.status), d.pull.size());
      });
}

void bind_sensed_link(nb::module_& m) {
  using Link = SensedLink;
  nb::class_<Link>(m, "SensedLink", "Link on which a Sensor locates contacts.")
      .def_prop_ro(
          "name", [](const Link& l) { return l.sensor->link_name(l.index); }, "name of the link, as robot/link")
      .def_prop_ro(
          "p_L", [](const Link& l) { return Rows(l.get().batch.rows.topRows(3).leftCols(l.get().batch.size).transpose()); },
          "sample points in the frame of the link [m] (samples, 3)")
      .def_prop_ro(
          "n_L", [](const Link& l) { return Rows(-l.get().batch.rows.middleRows(3, 3).leftCols(l.get().batch.size).transpose()); },
          "outward unit normals at the sample points (samples, 3)")
      .def_prop_ro(
          "spacing", [](const Link& l) { return l.get().spacing; }, "square root of the area per sample [m]")
      .def_prop_ro(
          "joints", [](const Link& l) { return l.get().joints; },
          "number of joints that move the link; below 3, contact forces are not unique, and below 5, contact points are not unique")
      .def_prop_ro(
          "area", [](const Link& l) { return l.get().surface.area; }, "area of its surface [m^2]")
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
  nb::enum_<Verdict>(m, "Verdict", "Whether the joint torques show a contact.")
      .value("BelowThreshold", Verdict::BelowThreshold, "no contact, or a contact that these torques do not show")
      .value("Explained", Verdict::Explained, "at least one candidate explains the torques within noise and tolerance")
      .value("Unexplained", Verdict::Unexplained,
             "no single contact on the sensed links explains the torques: several contacts, another link, or a wrong friction");
  bind_sensed_link(m);
  bind_candidate(m);
  bind_discrimination(m);
  bind_posterior(m);
  const sensing::DiscriminationOptions discrimination;
  using Result = sensing::SenseResult;
  nb::class_<SenseResult>(m, "SenseResult", "Contacts that explain the joint torques of one measurement.")
      .def_prop_ro("verdict", of_result(&Result::verdict), "whether a contact explains the torques")
      .def_prop_ro("candidates", &candidates_of,
                   "candidates that explain the torques, ordered by objective; then the others, ordered by residual")
      .def_prop_ro("explained", of_result(&Result::explained), "largest residual l that counts as explained [(N m)^2]")
      .def_prop_ro("posterior", &posterior_of, "Posterior, or None without posterior=True")
      .def_prop_ro(
          "largest", [](const SenseResult& r) { return r.result.largest.torque; },
          "torque that is largest relative to its noise, minus rest [N m; N]")
      .def_prop_ro(
          "largest_joint", [](const SenseResult& r) { return r.result.largest.joint; }, "index of the joint with this torque")
      .def_prop_ro("threshold", of_result(&Result::threshold), "torque of this joint from which the search for contacts begins [N m; N]")
      .def_prop_ro("noise", of_result(&Result::noise),
                   "noise of each torque in the coordinates of the residuals, so that residual/noise^2 has no unit [N m]")
      .def_prop_ro("friction", of_result(&Result::friction),
                   "friction coefficient of the search; larger than the given one if that explained nothing")
      .def_prop_ro("samples", of_result(&Result::samples), "number of samples")
      .def_prop_ro("accepted", of_result(&Result::accepted), "number of samples with a small enough residual")
      .def_prop_ro("descents", of_result(&Result::descents), "number of descents")
      .def_prop_ro("converged", of_result(&Result::converged), "number of descents that converged")
      .def(
          "calc_distance", &calc_distance, "link"_a, "p_L"_a,
          R"(Returns the distance of a known contact from the nearest point that explains the torques [m]; inf if no such point is on that link.

  link: link of the known contact, as "robot/link".
  p_L: known contact point in the frame of the link [m] (3).)")
      .def("discriminate", &discriminate, "q"_a, nb::kw_only(), "all"_a = false, "joint_step"_a = discrimination.joint_step,
           "travel"_a = nb::none(), "least"_a = discrimination.least, "sideways"_a = discrimination.sideways,
           R"(Finds a small motion that distinguishes the candidates (4.13).

The motion pulls away from about half of the candidates and pushes into the others. The change of the torques then refutes one half.

  q: configuration of the measurement (n_q), or joint positions alone (n_a).
  all: True: distinguish all candidates. False: only the candidates that explain the torques.
  joint_step: largest change of a joint [rad or m], > 0.
  travel: largest motion of a contact point [m], > 0. None: a tenth of joint_step times the longest reach.
  least: smallest motion along the normal at a contact, as a share of travel, in (0, 1).
  sideways: largest sliding motion at a contact, as a share of travel.

Returns a Discrimination. Raises InvalidInput: options out of range, no candidate.)")
      .def("__repr__", [](const SenseResult& r) {
        return fmt::format("<stiction.SenseResult: {}, {} candidates>", sensing::to_string(r.result.verdict), r.result.candidates.size());
      });
  def_pickle<Candidate, sensing::Discrimination, SensedLink, SenseResult, Posterior>();
}

}  // namespace stiction::python
