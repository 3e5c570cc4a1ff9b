// What figures 4-3 to 4-9 show, as one JSON object: sensing_maps [SAMPLES]
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "known_arms.hpp"
#include "stiction/core/random.hpp"
#include "stiction/sensing/detectability.hpp"
#include "stiction/sensing/discriminate.hpp"

namespace {

using namespace stiction;
using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

constexpr double kEpsilons[] = {0.0025, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05};  // [N m/N]
constexpr double kEpsilon = 0.02;
constexpr int kDirections = 200;          // of a dome (4.8)
constexpr Eigen::Index kReadings = 4000;  // samples for which they are drawn
constexpr int kShown = 1500;              // points of a picture
constexpr std::uint64_t kSeeds = 8;       // of 1000 samples each, to see how much counts scatter
// Residuals of the thesis's figures have a factor ½.
constexpr double kDelta = 2 * 0.1, kEps = 2 * 0.005;  // [(N m)²]

std::shared_ptr<const sensing::Sensor> make_sensor(const bench::Arm& arm, std::vector<std::string> links, int samples, bool hidden_faces) {
  sensing::SensorOptions options;
  options.links = std::move(links);
  options.samples = samples;
  options.sampling = sensing::Sampling::Uniform;
  if (hidden_faces) options.surface.rays = 0;
  return bench::make_sensor(arm, options);
}

Json numbers(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// η_ε of (4.8) as the thesis computes it, by directions uniform on the dome of the cone. @param rays  0: the exact cone
/// @param with_sign  τ ≤ ε as (4.8c) is printed; else |τ| ≤ ε
double sample_undetectability(const Vector3d& lever, const Eigen::Matrix3d& R_LC, int rays, bool with_sign, core::Random& random) {
  const sensing::FrictionCone cone(1, rays);
  const double least = 1 / std::sqrt(2.0);  // cosine of the half angle of μ = 1, around the polyhedral cone too
  const Vector3d lever_C = R_LC.transpose() * lever;
  int inside = 0, missed = 0;
  while (inside < kDirections) {
    const double x = random.uniform(least, 1), angle = random.uniform(0, 2 * std::numbers::pi), r = std::sqrt(1 - x * x);
    const Vector3d f(x, r * std::cos(angle), r * std::sin(angle));
    const auto V = cone.ray_matrix();
    bool within = true;
    for (int i = 0; i < rays && within; ++i) within = Vector3d(V.col(i)).cross(Vector3d(V.col((i + 1) % rays))).dot(f) >= 0;
    if (!within) continue;
    ++inside;
    const double torque = lever_C.dot(f);
    missed += (with_sign ? torque : std::abs(torque)) <= kEpsilon;
  }
  return static_cast<double>(missed) / kDirections;
}

/// Shares of samples with η ≥ 0.4 for what the thesis leaves open: the cone of the dome, and whether the sign of τ counts.
Json hard_shares(const sensing::SampleBatch& batch, const sensing::JointLine& line) {
  Json out;
  const Eigen::Index n = std::min<Eigen::Index>(batch.size, kReadings);
  for (const int rays : {3, 4, 6, 8, 0}) {
    for (const bool with_sign : {false, true}) {
      core::Random random(7, static_cast<std::uint64_t>(rays));
      int hard = 0;
      for (Eigen::Index i = 0; i < n; ++i)
        hard += sample_undetectability(line.lever(batch.p_L(i)), batch.R_LC(i), rays, with_sign, random) >= 0.4;
      out[with_sign ? "signed" : "absolute"][rays > 0 ? std::to_string(rays) : "exact"] =
          static_cast<double>(hard) / static_cast<double>(n);
    }
  }
  return out;
}

/// Figs 4-4 and 4-5 of one link. @param axis  instead of that of the joint, through the same point; nullptr: the joint's
Json detectability(const std::string& name, const bench::Arm& arm, const char* link_name, int samples, bool hidden_faces,
                   const Vector3d* axis) {
  const auto sensor = make_sensor(arm, {link_name}, samples, hidden_faces);
  const sensing::SensedLink& link = sensor->links()[0];
  sensing::JointLine line = sensing::find_joint_line(sensor->model(), link.surface.body);
  if (axis != nullptr) line.axis_L = *axis;
  Json out{{"name", name},
           {"link", link_name},
           {"axis_L", numbers(line.axis_L)},
           {"hidden_faces", hidden_faces},
           {"samples", samples},
           {"triangles", link.surface.tree.size()}};
  const auto n = static_cast<double>(link.batch.size);
  for (const int rays : {3, 4, 6, 8, 16, 0}) {
    int full = 0;
    for (Eigen::Index i = 0; i < link.batch.size; ++i)
      full += sensing::classify(line.lever(link.batch.p_L(i)), link.batch.R_LC(i), sensing::FrictionCone(1, rays)) ==
              sensing::Detectability::Full;
    out["full"][rays > 0 ? std::to_string(rays) : "exact"] = full / n;
  }
  const auto eta = [&](Eigen::Index i, double epsilon) {
    return sensing::calc_undetectability(line.lever(link.batch.p_L(i)), link.batch.R_LC(i).col(0), 1, epsilon);
  };
  for (const double epsilon : kEpsilons) {
    double sum = 0;
    int blind = 0, hard = 0;
    for (Eigen::Index i = 0; i < link.batch.size; ++i) {
      const double value = eta(i, epsilon);
      sum += value;
      hard += value >= 0.4;
      blind += value >= 0.999;
    }
    out["eta"].push_back({{"epsilon", epsilon}, {"mean", sum / n}, {"at_least_0_4", hard / n}, {"all", blind / n}});
  }
  out["at_least_0_4"] = hard_shares(link.batch, line);
  for (Eigen::Index i = 0; i < std::min<Eigen::Index>(link.batch.size, kShown); ++i) {
    const auto kind = sensing::classify(line.lever(link.batch.p_L(i)), link.batch.R_LC(i), sensing::FrictionCone(1, 4));
    out["points"].push_back(
        {link.batch.p_L(i).x(), link.batch.p_L(i).y(), link.batch.p_L(i).z(), eta(i, kEpsilon), static_cast<int>(kind)});
  }
  return out;
}

/// The case of Figs 4-6 to 4-10, torques as published.
struct Case {
  Eigen::VectorXd q{{-1.75956086, 0.74755266, 2.72834054, 2.05278647, 2.3270361, -1.27883698, 0.61326711}};
  Eigen::VectorXd tau{{0.966613398, -2.82202806, -0.00160744425, 0.662280818, 0.0319086728, 0.0817417009, 0}};
};

struct At {
  world::Kinematics kinematics;
  std::vector<sensing::LinkTorque> torques;
};

At place(const sensing::Sensor& sensor, const Case& c) {
  At at;
  world::KinematicsWorkspace work(sensor.model());
  world::calc_kinematics(sensor.model(), c.q, work, at.kinematics);
  Eigen::Matrix3Xd J_w, J_v;
  for (const sensing::SensedLink& link : sensor.links()) {
    sensing::calc_link_jacobian(sensor.model(), at.kinematics, link.surface.body, J_w, J_v);
    at.torques.emplace_back(J_w, J_v, c.tau);
  }
  return at;
}

/// Figs 4-3 and 4-6: x, y, z in W, residual, link.
Json residual_map(const Case& c, int samples, int shown, bool hidden_faces) {
  const auto sensor = make_sensor(bench::best_iiwa(), {"arm/link_5", "arm/link_6"}, samples / 2, hidden_faces);
  const At at = place(*sensor, c);
  const sensing::FrictionCone cone(1, 4);
  Json out{{"samples", 2 * (samples / 2)}, {"points", Json::array()}};
  int eps = 0, delta = 0;
  for (std::size_t k = 0; k < sensor->links().size(); ++k) {
    const sensing::SensedLink& link = sensor->links()[k];
    const world::Pose& X_WL = at.kinematics.X_WB[static_cast<std::size_t>(link.surface.body)];
    Eigen::VectorXd values(link.batch.rows.cols());
    sensing::calc_residuals(at.torques[k], link.batch, cone, values);
    for (Eigen::Index i = 0; i < link.batch.size; ++i) {
      eps += values[i] <= kEps;
      delta += values[i] <= kDelta;
      if (i >= shown / 2) continue;
      const Vector3d p_W = X_WL * link.batch.p_L(i);
      out["points"].push_back(
          {p_W.x(), p_W.y(), p_W.z(), values[i], sensor->model().bodies()[static_cast<std::size_t>(link.surface.body)].name});
    }
  }
  out["accepted_eps"] = eps;
  out["accepted_delta"] = delta;
  return out;
}

/// Figs 4-7 and 4-8: from every accepted sample to where Algorithm 4 ends. @param seed  of the samples
Json descents(const Case& c, int samples, std::uint64_t seed) {
  const auto sensor = make_sensor(bench::best_iiwa(), {"arm/link_5", "arm/link_6"}, 1, false);
  const At at = place(*sensor, c);
  const sensing::FrictionCone cone(1, 4);
  Json runs = Json::array();
  for (std::size_t k = 0; k < sensor->links().size(); ++k) {
    const sensing::SensedLink& link = sensor->links()[k];
    const world::Pose& X_WL = at.kinematics.X_WB[static_cast<std::size_t>(link.surface.body)];
    const sensing::DescentProblem problem{link, static_cast<int>(k),       at.torques[k],
                                          cone, sensor->options().normals, sensing::SenseOptions{}.tolerance};
    for (const sensing::SurfacePoint& sample : sensing::sample_surface(link.surface, samples / 2, sensing::Sampling::Uniform, seed)) {
      const sensing::ContactPoint start = sensing::evaluate(problem, sample.triangle, sample.p_L);
      if (start.residual > kDelta) continue;
      sensing::ContactPoint end = start;
      const bool converged = sensing::descend(problem, sensing::SteepestDescent{}, end);
      runs.push_back({{"link", sensor->link_name(static_cast<int>(k))},
                      {"start", numbers(X_WL * start.p_L)},
                      {"end", numbers(X_WL * end.p_L)},
                      {"before", start.residual},
                      {"after", end.residual},
                      {"force", end.f_L.norm()},
                      {"converged", converged}});
    }
  }
  return runs;
}

/// Fig. 4-9: the best point of each link, and the motion that tells them apart.
Json discrimination(const Case& c) {
  const auto sensor = make_sensor(bench::best_iiwa(), {"arm/link_5", "arm/link_6"}, 500, false);
  sensing::SenseOptions options;
  options.noise = 1e-3;
  options.accept = kDelta;
  sensing::SenseWorkspace work(sensor);
  sensing::SenseResult result;
  sensing::sense(*sensor, {c.q, c.tau}, options, work, result);
  std::vector<sensing::Candidate> two;
  for (int link = 0; link < 2; ++link)
    for (const sensing::Candidate& candidate : result.candidates)
      if (candidate.best.link == link) {
        two.push_back(candidate);
        break;
      }
  sensing::Discrimination motion;
  Json out{{"candidates", Json::array()}};
  if (two.size() == 2) (void)sensing::discriminate(*sensor, c.q, two, {}, motion);
  out["status"] = std::string(core::to_string(motion.status));
  for (std::size_t i = 0; i < two.size(); ++i)
    out["candidates"].push_back({{"link", sensor->link_name(two[i].best.link)},
                                 {"p_W", numbers(two[i].p_W)},
                                 {"n_W", numbers(two[i].n_W)},
                                 {"f_W", numbers(two[i].f_W)},
                                 {"residual", two[i].best.residual},
                                 {"pull", motion.pull.empty() ? -1 : motion.pull[i]}});
  out["dq"] = std::vector<double>(motion.dq.data(), motion.dq.data() + motion.dq.size());
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  const int samples = argc > 1 ? std::max(100, std::atoi(argv[1])) : 20000;
  const Vector3d x = Vector3d::UnitX();
  const Case c;
  Json out;
  out["iiwa"] = bench::best_iiwa().name;
  out["detectability"] = {
      detectability(bench::best_iiwa().name + ", link 6", bench::best_iiwa(), "arm/link_6", samples, false, nullptr),
      detectability(bench::best_iiwa().name + ", link 6, all faces", bench::best_iiwa(), "arm/link_6", samples, true, nullptr),
      detectability("UR5 forearm", bench::kUr5, "arm/forearm_link", samples, true, nullptr),
      detectability("UR5 forearm, axis x", bench::kUr5, "arm/forearm_link", samples, true, &x),
      detectability("UR5 forearm, what can be touched", bench::kUr5, "arm/forearm_link", samples, false, nullptr),
      detectability("Panda link 6", bench::kPanda, "arm/panda_link6", samples, false, nullptr)};
  out["dense"] = residual_map(c, samples, 3000, false);
  out["sparse"] = residual_map(c, 1000, 1000, false);
  out["all_faces"] = residual_map(c, samples, 0, true);
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) out["descents"].push_back(descents(c, 1000, seed));
  out["discrimination"] = discrimination(c);
  fmt::print("{}\n", out.dump());
}
