// How often the truth is among the points that an estimator names: random contacts of 10 N behind at least five joints, and what noise, bias, a wrong friction
// and few samples do to it. sensing_recall [CASES [CASES_OF_SWEEPS]] [--json]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "stiction/core/quantile.hpp"
#include "stiction/sensing/line_of_action.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/world/read.hpp"

namespace {

using namespace stiction;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr double kForce = 10;   // [N]
constexpr double kNear = 0.01;  // what counts as found [m]
constexpr int kRays = 4;
constexpr double kFriction = 1;
constexpr double kLeastNoise = 1e-4;  // assumed where there is none [N m]

struct Arm {
  const char* name;
  const char* urdf;
};
constexpr Arm kArms[] = {{"ur5", "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"},
                         {"panda", "package://example-robot-data/robots/panda_description/urdf/panda.urdf"},
                         {"iiwa of capsules", "models/iiwa_primitives.urdf"}};

struct Setting {
  const char* estimator = "gauss_newton";
  double noise = 0;           ///< standard deviation of each torque [N m]
  double bias = 0;            ///< of each torque, with a random sign that stays for a case [N m]
  double friction_ratio = 1;  ///< assumed over true
  int samples = 500;          ///< on each link
};

std::shared_ptr<const sensing::Sensor> make_sensor(const Arm& arm, int samples) {
  const std::vector<std::filesystem::path> packages{STICTION_PACKAGE_DIR};
  const auto scene = world::parse_scene(fmt::format("robots: [{{name: arm, urdf: '{}'}}]", arm.urdf), STICTION_SOURCE_DIR, packages);
  sensing::SensorOptions options;
  options.samples = samples;
  return sensing::Sensor::make(world::Model::make(scene), options);
}

/// What an estimator says of one measurement: points that it holds for possible, and how many places they are.
struct Estimate {
  std::vector<sensing::ContactPoint> points;
  int places = 0;
};

/// sense() with one of its methods, or a baseline.
class Estimator {
 public:
  Estimator(std::shared_ptr<const sensing::Sensor> sensor, const Setting& setting) : sensor_(std::move(sensor)), work_(sensor_) {
    options_.cone = sensing::FrictionCone(setting.friction_ratio * kFriction, kRays);
    options_.noise = std::max(std::hypot(setting.noise, setting.bias), kLeastNoise);
    const std::string_view name = setting.estimator;
    if (name == "rsgd") options_.method = sensing::SteepestDescent{};
    if (name == "rejection") options_.method = sensing::RejectionSampling{};
    by_line_ = name == "line_of_action";
  }

  void run(const sensing::KnownCase& c, Estimate& out) {
    if (by_line_) {
      out.points = sensing::find_line_of_action(*sensor_, c.q, c.tau, 3 * options_.noise).points;
      out.places = static_cast<int>(out.points.size());
      return;
    }
    sensing::sense(*sensor_, {c.q, c.tau}, options_, work_, result_);
    out.points.clear();
    out.places = 0;
    for (const sensing::Candidate& candidate : result_.candidates) {
      if (!candidate.explains) continue;
      ++out.places;
      for (int i = candidate.first; i < candidate.first + candidate.count; ++i) {
        const sensing::ContactPoint& point = result_.points[static_cast<std::size_t>(i)];
        if (point.residual <= std::max(result_.explained, candidate.best.residual)) out.points.push_back(point);
      }
    }
  }

 private:
  std::shared_ptr<const sensing::Sensor> sensor_;
  sensing::SenseOptions options_;
  bool by_line_ = false;
  sensing::SenseWorkspace work_;
  sensing::SenseResult result_;
};

Json measure(const Arm& arm, const std::shared_ptr<const sensing::Sensor>& sensor, const Setting& setting, int cases) {
  std::vector<int> links;
  for (int i = 0; i < static_cast<int>(sensor->links().size()); ++i)
    if (sensor->links()[static_cast<std::size_t>(i)].joints >= 5) links.push_back(i);
  Estimator estimator(sensor, setting);
  Estimate estimate;
  core::Random random(34, 0);
  int near = 0, right = 0, several = 0, none = 0;
  std::vector<double> seconds, distances, force_errors;
  for (int i = 0; i < cases; ++i) {
    sensing::KnownCase c = sensing::make_random_case(*sensor, links, sensing::FrictionCone(kFriction, kRays), kForce, random);
    for (double& torque : c.tau) {
      const double noise = random.normal();
      torque += setting.noise * noise + (random.chance(0.5) ? 1 : -1) * setting.bias;
    }
    const auto begin = Clock::now();
    estimator.run(c, estimate);
    seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
    const sensing::ContactPoint* nearest = nullptr;
    double distance = std::numeric_limits<double>::infinity();
    for (const sensing::ContactPoint& point : estimate.points) {
      const double d = (point.p_L - c.contact.p_L).norm();
      if (point.link == c.contact.link && d < distance) nearest = &point, distance = d;
    }
    right += nearest != nullptr;
    near += distance <= kNear;
    several += estimate.places > 1;
    none += estimate.places == 0;
    if (nearest == nullptr) continue;
    distances.push_back(distance);
    force_errors.push_back((nearest->f_L - c.contact.f_L).norm());
  }
  const auto share = [cases](int count) { return static_cast<double>(count) / cases; };
  return {{"arm", arm.name},
          {"estimator", setting.estimator},
          {"noise", setting.noise},
          {"bias", setting.bias},
          {"friction_ratio", setting.friction_ratio},
          {"samples", setting.samples},
          {"cases", cases},
          {"found", share(near)},
          {"right_link", share(right)},
          {"several", share(several)},
          {"none", share(none)},
          {"median_distance_m", core::quantile(distances, 0.5)},
          {"p90_distance_m", core::quantile(distances, 0.9)},
          {"median_force_error_N", core::quantile(force_errors, 0.5)},
          {"p90_force_error_N", core::quantile(force_errors, 0.9)},
          {"median_s", core::quantile(seconds, 0.5)},
          {"p99_s", core::quantile(seconds, 0.99)}};
}

void print(const Json& row) {
  fmt::print(
      "{:17} {:13} noise {:4.2f} bias {:4.2f} N m, friction {:4.2f}, {:4} samples: within 1 cm {:5.1f} %, right link {:5.1f} %, several "
      "places {:5.1f} %, "
      "none {:5.1f} %, median {:.1f} mm, {:.2f} N, {:.2f} ms, p99 {:.2f} ms\n",
      row["arm"].get<std::string>(), row["estimator"].get<std::string>(), row["noise"].get<double>(), row["bias"].get<double>(),
      row["friction_ratio"].get<double>(), row["samples"].get<int>(), 100 * row["found"].get<double>(),
      100 * row["right_link"].get<double>(), 100 * row["several"].get<double>(), 100 * row["none"].get<double>(),
      1e3 * row["median_distance_m"].get<double>(), row["median_force_error_N"].get<double>(), 1e3 * row["median_s"].get<double>(),
      1e3 * row["p99_s"].get<double>());
}

const std::vector<Setting> kSettings = {
    {"gauss_newton"}, {"rsgd"}, {"rejection"}, {"line_of_action"}, {"gauss_newton", 0.1, 0, 0.7}, {"line_of_action", 0.1, 0, 0.7}};

/// One quantity at a time, with some noise in all of them.
std::vector<Setting> make_sweeps() {
  std::vector<Setting> out;
  for (const double noise : {0.01, 0.03, 0.1, 0.3}) out.push_back({"gauss_newton", noise});
  for (const double bias : {0.01, 0.03, 0.1, 0.3}) out.push_back({"gauss_newton", 0.03, bias});
  for (const double ratio : {0.5, 0.7, 0.85, 1.2, 1.5}) out.push_back({"gauss_newton", 0.03, 0, ratio});
  for (const int samples : {20, 50, 100, 200, 1000}) out.push_back({"gauss_newton", 0.03, 0, 1, samples});
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> counts;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--json")
      json = true;
    else
      counts.push_back(std::max(1, std::atoi(argv[i])));
  }
  const int cases = counts.empty() ? 1000 : counts[0], sweep_cases = counts.size() > 1 ? counts[1] : std::max(1, cases / 5);
  Json rows = Json::array();
  const auto add = [&](const Arm& arm, const std::shared_ptr<const sensing::Sensor>& sensor, const Setting& setting, int n) {
    rows.push_back(measure(arm, sensor, setting, n));
    if (!json) print(rows.back());
  };
  for (const Arm& arm : kArms) {
    const auto sensor = make_sensor(arm, Setting{}.samples);
    for (const Setting& setting : kSettings) add(arm, sensor, setting, cases);
  }
  const Arm& swept = kArms[2];
  for (const Setting& setting : make_sweeps()) add(swept, make_sensor(swept, setting.samples), setting, sweep_cases);
  if (json) fmt::print("{}\n", rows.dump());
}
