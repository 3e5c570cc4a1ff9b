#include "sense_page.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/sensing/detectability.hpp"
#include "stiction/sensing/residual_map.hpp"

namespace stiction::app {
namespace {

using Json = nlohmann::ordered_json;

std::vector<int> sensed_bodies(const sensing::Sensor& sensor) {
  std::vector<int> out;
  for (const auto& link : sensor.links()) out.push_back(link.surface.body);
  return out;
}

/// Rounded to what a picture shows [m].
double millionth(double x) { return std::round(x * 1e6) / 1e6 + 0.0; }

Json flat(const Eigen::Ref<const Eigen::MatrixXd>& columns) {
  Json out = Json::array();
  for (const double x : columns.reshaped()) out.push_back(millionth(x));
  return out;
}

/// Triangles that can be touched, and samples with their outward normals, in the frame of the link.
Json to_json(const sensing::SensedLink& link, const std::string& name, int body) {
  Json points = Json::array(), normals = Json::array();
  for (Eigen::Index i = 0; i < link.batch.size; ++i) {
    const Eigen::Vector3d p_L = link.batch.p_L(i), n_L = -link.batch.R_LC(i).col(0);
    for (const double x : p_L) points.push_back(millionth(x));
    for (const double x : n_L) normals.push_back(millionth(x));
  }
  return {{"name", name},
          {"body", body},
          {"spacing", link.spacing},
          {"corners", flat(link.surface.tree.corners())},
          {"normals", flat(link.surface.normals)},
          {"points", std::move(points)},
          {"point_normals", std::move(normals)}};
}

/// At every sample of a link the probability of a touch that likelier places hold: up to 0.95 it belongs to the credible set. Where samples stand for others, those beside a
/// place have its value; all others 1.
std::vector<double> credible_levels(const sensing::Sensor& sensor, int link, const sensing::Posterior& posterior) {
  constexpr double kBeside = 2;  // of the spacing of samples
  const sensing::SampleBatch& batch = sensor.links()[static_cast<std::size_t>(link)].batch;
  const double reach = kBeside * sensor.links()[static_cast<std::size_t>(link)].spacing, touched = 1 - posterior.nothing;
  std::vector<double> out(static_cast<std::size_t>(batch.size), 1), nearest(out.size(), reach);
  double before = 0;
  for (const sensing::TouchedPlace& place : posterior.places) {
    const double level = touched > 0 ? std::min(1.0, before / touched) : 1;
    before += place.probability;
    if (place.link != link) continue;
    for (Eigen::Index i = 0; i < batch.size; ++i) {
      const double distance = i == place.sample ? 0 : (batch.p_L(i) - batch.p_L(place.sample)).norm();
      if (!(distance < nearest[static_cast<std::size_t>(i)])) continue;
      nearest[static_cast<std::size_t>(i)] = distance;
      out[static_cast<std::size_t>(i)] = level;
    }
  }
  return out;
}

/// Probabilities of links, and the credible set of links and places.
Json to_json(const sensing::Sensor& sensor, const sensing::Posterior& posterior) {
  Json out{{"nothing", posterior.nothing}, {"credible", Json::array()}, {"levels", Json::array()}};
  for (const int link : posterior.credible)
    out["credible"].push_back({{"link", sensor.link_name(link)}, {"probability", posterior.links[static_cast<std::size_t>(link)]}});
  for (int link = 0; link < static_cast<int>(sensor.links().size()); ++link)
    out["levels"].push_back(credible_levels(sensor, link, posterior));
  return out;
}

/// Torque of a joint from which on it shows a contact [N·m; N]; infinite without a torque sensor.
double calc_threshold(const sensing::SenseOptions& options, int joint) {
  const sensing::TorqueModel& torques = options.torques;
  if (std::ranges::find(torques.unmeasured, joint) != torques.unmeasured.end()) return std::numeric_limits<double>::infinity();
  const double noise = torques.covariance.size() == 0 ? options.noise : std::sqrt(torques.covariance(joint, joint));
  return options.threshold.value_or(noise * (torques.deviations.size() == 0 ? sensing::kDeviations : torques.deviations[joint]));
}

}  // namespace

SensePage::SensePage(const sensing::Scenario& scenario)
    : scenario_(scenario), scene_(scenario.sensor->model(), sensed_bodies(*scenario.sensor)), moments_(Json::array()) {}

void SensePage::add(std::size_t i, const Eigen::VectorXd& q, const Eigen::VectorXd& tau, const sensing::SenseResult& result,
                    const sensing::ContactSetResult& sets) {
  const sensing::FrictionCone cone(result.friction, scenario_.options.cone.is_lorentz() ? 0 : std::max(3, scenario_.options.cone.rays()));
  sensing::WhitenedTorques whitened;
  whitened.assign(scenario_.options.torques, tau, scenario_.options.noise, scenario_.options.tolerance);
  Json moment{{"t", scenario_.series.times[i]},
              {"bodies", scene_.poses(q)},
              {"verdict", sensing::to_string(result.verdict)},
              {"tau_norm", whitened.tau().norm()}};
  moment["residuals"] = Json::array();
  for (const Eigen::VectorXd& link : sensing::calc_residual_map(*scenario_.sensor, q, tau, cone, &whitened))
    moment["residuals"].push_back(std::vector<double>(link.begin(), link.end()));
  moment["candidates"] = Json::array();
  for (const sensing::Candidate& c : result.candidates) {
    if (c.explains && first_force_ == 0) first_force_ = c.f_W.norm();
    moment["candidates"].push_back({{"link", scenario_.sensor->link_name(c.best.link)},
                                    {"explains", c.explains},
                                    {"residual", c.best.residual},
                                    {"probability", c.probability},
                                    {"extent", c.extent},
                                    {"point", page_numbers(c.p_W)},
                                    {"force", page_numbers(c.f_W)}});
  }
  if (!result.posterior.links.empty()) moment["posterior"] = to_json(*scenario_.sensor, result.posterior);
  moment["truths"] = truths(i, q);
  if (scenario_.asks_for_sets()) moment["contact_sets"] = contact_sets(q, sets);
  moments_.push_back(std::move(moment));
}

/// Points and forces in W of the known contacts that act. A push has its force in the world, another contact in its link.
Json SensePage::truths(std::size_t i, const Eigen::VectorXd& q) const {
  const world::Model& model = scenario_.sensor->model();
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  Json out = Json::array();
  const std::vector<sensing::ContactPoint> contacts = scenario_.contacts_at(i);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const sensing::ContactPoint& contact = contacts[k];
    const auto& X_WL =
        kinematics.X_WB[static_cast<std::size_t>(scenario_.sensor->links()[static_cast<std::size_t>(contact.link)].surface.body)];
    Eigen::Vector3d f_W = X_WL.R * contact.f_L;
    if (scenario_.poke) f_W = scenario_.poke->pushes[static_cast<std::size_t>(scenario_.series.pushed[i][k])].force_W;
    out.push_back({{"point", page_numbers(X_WL * contact.p_L)}, {"force", page_numbers(f_W)}});
  }
  return out;
}

/// The best set of every combination of links.
Json SensePage::contact_sets(const Eigen::VectorXd& q, const sensing::ContactSetResult& result) const {
  const world::Model& model = scenario_.sensor->model();
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  Json groups = Json::array();
  for (const sensing::ContactGroup& group : result.groups) {
    const sensing::ContactSet& best = result.sets[static_cast<std::size_t>(group.first)];
    Json contacts = Json::array();
    for (std::size_t i = 0; i < static_cast<std::size_t>(best.count); ++i) {
      const sensing::ContactPoint& point = best.contacts[i];
      const auto& X_WL =
          kinematics.X_WB[static_cast<std::size_t>(scenario_.sensor->links()[static_cast<std::size_t>(point.link)].surface.body)];
      contacts.push_back({{"link", scenario_.sensor->link_name(point.link)},
                          {"point", page_numbers(X_WL * point.p_L)},
                          {"force", page_numbers(X_WL.R * point.f_L)},
                          {"deviation", best.deviation[i]},
                          {"unique", best.point_is_unique[i]}});
    }
    groups.push_back({{"contacts", std::move(contacts)}, {"residual", best.residual}});
  }
  return {{"explained", result.verdict == sensing::Verdict::Explained},
          {"ambiguous", result.ambiguous},
          {"count", result.contacts},
          {"groups", std::move(groups)}};
}

/// η (4.8) at every sample: ε is the torque of a unit force whose torque at the given size is just the threshold of the joint before the link.
Json SensePage::detectability(double force) const {
  const world::Model& model = scenario_.sensor->model();
  Json links = Json::array(), thresholds = Json::array();
  for (const auto& link : scenario_.sensor->links()) {
    const double threshold = calc_threshold(scenario_.options, sensing::find_joint_line(model, link.surface.body).joint);
    const bool is_measured = std::isfinite(threshold);
    thresholds.push_back(is_measured ? Json(threshold) : Json());
    const Eigen::VectorXd eta = is_measured ? sensing::calc_detectability(model, link, scenario_.options.cone, threshold / force).eta
                                            : Eigen::VectorXd::Ones(link.batch.size);
    links.push_back(std::vector<double>(eta.begin(), eta.end()));
  }
  return {{"force", force}, {"thresholds", std::move(thresholds)}, {"eta", std::move(links)}};
}

std::string SensePage::document(double force) const {
  const sensing::Sensor& sensor = *scenario_.sensor;
  Json out{{"format", "stiction-sense"}, {"format_version", 1}, {"scenario", scenario_.name}, {"description", scenario_.description}};
  out["friction"] = scenario_.options.cone.friction();
  scene_.write(out);
  out["links"] = Json::array();
  for (std::size_t i = 0; i < sensor.links().size(); ++i) {
    const auto& link = sensor.links()[i];
    out["links"].push_back(to_json(link, sensor.link_name(static_cast<int>(i)), scene_.place(link.surface.body)));
  }
  out["truths"] = Json::array();
  for (const sensing::ContactPoint& truth : scenario_.contacts) {
    const auto& link = sensor.links()[static_cast<std::size_t>(truth.link)];
    out["truths"].push_back({{"body", scene_.place(link.surface.body)},
                             {"link", sensor.link_name(truth.link)},
                             {"point", page_numbers(truth.p_L)},
                             {"force", page_numbers(truth.f_L)}});
  }
  if (force <= 0) force = scenario_.contacts.empty() ? first_force_ : scenario_.contacts[0].f_L.norm();
  if (force > 0) out["detectability"] = detectability(force);
  out["moments"] = moments_;
  return out.dump();
}

}  // namespace stiction::app
