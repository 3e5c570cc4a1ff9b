// How often two or three contacts at the same time are found: forces of 10 N on as many links, from joint torques alone and with a wrench measured under the
// base. sensing_contacts [CASES] [--json]
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "known_arms.hpp"
#include "stiction/core/quantile.hpp"

namespace {

using namespace stiction;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr double kForce = 10;  // [N]
constexpr double kFriction = 1;
constexpr int kRays = 4;
constexpr int kSamples = 500;         // on each link
constexpr double kLeastNoise = 1e-4;  // assumed where there is none [N m]
constexpr double kTolerance = 1e-3;   // of what is measured that may be left where there is no noise
constexpr double kForceNoise = 5;     // of the wrench at the base, over that of a torque [1/m]

struct Setting {
  int contacts;
  bool base;
  double noise;   ///< standard deviation of each torque [N m]
  int times = 1;  ///< of the cases asked for: of this setting only a part can be isolated
};
constexpr Setting kSettings[] = {{2, false, 0}, {2, true, 0, 3}, {2, false, 0.1}, {2, true, 0.1}, {3, false, 0}, {3, true, 0}};

void disturb(sensing::KnownCases& c, const Setting& setting, core::Random& random) {
  const double assumed = std::max(setting.noise, kLeastNoise);
  c.base.force_noise = kForceNoise * assumed;
  c.base.moment_noise = assumed;
  for (double& torque : c.tau) torque += setting.noise * random.normal();
  for (double& force : c.base.force_W) force += kForceNoise * setting.noise * random.normal();
  for (double& moment : c.base.moment_W) moment += setting.noise * random.normal();
}

double force_error(const sensing::ContactSet& set, const sensing::KnownCases& c) {
  double out = 0;
  for (std::size_t i = 0; i < c.contacts.size(); ++i) out = std::max(out, (set.contacts[i].f_L - c.contacts[i].f_L).norm());
  return out;
}

Json measure(const bench::Arm& arm, const std::shared_ptr<const sensing::Sensor>& sensor, const Setting& setting, int cases) {
  const std::vector<int> links = bench::links_behind(*sensor, 1);
  sensing::ContactSetOptions options;
  options.max_contacts = setting.contacts;
  options.sense.cone = sensing::FrictionCone(kFriction, kRays);
  options.sense.noise = std::max(setting.noise, kLeastNoise);
  if (setting.noise == 0) options.sense.tolerance = kTolerance;
  sensing::ContactSetWorkspace work(sensor);
  sensing::ContactSetResult result;
  core::Random random(34, 1);
  int fewer = 0, unexplained = 0, right = 0, near = 0, nearer = 0, ambiguous = 0, isolated = 0, isolated_near = 0;
  std::vector<double> seconds, distances, force_errors;
  for (int i = 0; i < cases; ++i) {
    sensing::KnownCases c = sensing::make_random_cases(*sensor, links, options.sense.cone, kForce, setting.contacts, random);
    disturb(c, setting, random);
    const auto begin = Clock::now();
    sensing::sense_contacts(*sensor, {c.q, c.tau, setting.base ? &c.base : nullptr}, options, work, result);
    seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
    const bool explained = result.verdict == sensing::Verdict::Explained;
    unexplained += !explained;
    fewer += explained && result.contacts < setting.contacts;
    ambiguous += result.ambiguous;
    const sensing::ContactSet* nearest = nullptr;
    double distance = std::numeric_limits<double>::infinity();
    for (const sensing::ContactSet& set : result.sets) {
      const double d = sensing::calc_distance(set, c.contacts);
      if (explained && d < distance) nearest = &set, distance = d;
    }
    const bool is_isolated = sensing::calc_freedom(*sensor, c, setting.base, options.sense.noise) == 0;
    isolated += is_isolated;
    isolated_near += is_isolated && distance <= 0.01;
    near += distance <= 0.05;
    nearer += distance <= 0.01;
    right += nearest != nullptr;
    if (nearest == nullptr) continue;
    distances.push_back(distance);
    force_errors.push_back(force_error(*nearest, c));
  }
  const auto share = [cases](int count) { return static_cast<double>(count) / cases; };
  return {{"arm", arm.name},
          {"contacts", setting.contacts},
          {"base_wrench", setting.base},
          {"noise", setting.noise},
          {"cases", cases},
          {"within_1_cm", share(nearer)},
          {"within_5_cm", share(near)},
          {"right_links", share(right)},
          {"fewer_do", share(fewer)},
          {"unexplained", share(unexplained)},
          {"ambiguous", share(ambiguous)},
          {"isolated", share(isolated)},
          {"isolated_within_1_cm", isolated > 0 ? static_cast<double>(isolated_near) / isolated : std::numeric_limits<double>::quiet_NaN()},
          {"median_distance_m", core::quantile(distances, 0.5)},
          {"p90_distance_m", core::quantile(distances, 0.9)},
          {"median_force_error_N", core::quantile(force_errors, 0.5)},
          {"p90_force_error_N", core::quantile(force_errors, 0.9)},
          {"median_s", core::quantile(seconds, 0.5)},
          {"p99_s", core::quantile(seconds, 0.99)}};
}

void print(const Json& row) {
  const auto percent = [&](const char* key) { return 100 * row[key].get<double>(); };
  fmt::print(
      "{:17} {} contacts{}, noise {:3.1f} N m: both within 1 cm {:5.1f} %, 5 cm {:5.1f} %, right links {:5.1f} %, fewer do {:5.1f} %, "
      "unexplained {:5.1f} %, "
      "ambiguous {:5.1f} %, isolated {:5.1f} %, of them within 1 cm {:5.1f} %, median {:.1f} mm, {:.2f} N, {:.1f} ms, p99 {:.1f} ms\n",
      row["arm"].get<std::string>(), row["contacts"].get<int>(), row["base_wrench"].get<bool>() ? " and base" : "",
      row["noise"].get<double>(), percent("within_1_cm"), percent("within_5_cm"), percent("right_links"), percent("fewer_do"),
      percent("unexplained"), percent("ambiguous"), percent("isolated"), percent("isolated_within_1_cm"),
      1e3 * row["median_distance_m"].get<double>(), row["median_force_error_N"].get<double>(), 1e3 * row["median_s"].get<double>(),
      1e3 * row["p99_s"].get<double>());
}

}  // namespace

int main(int argc, char** argv) {
  int cases = 100;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--json")
      json = true;
    else
      cases = std::max(1, std::atoi(argv[i]));
  }
  Json rows = Json::array();
  for (const bench::Arm& arm : bench::list_arms()) {
    const auto sensor = bench::make_sensor(arm, {.samples = kSamples});
    for (const Setting& setting : kSettings) {
      rows.push_back(measure(arm, sensor, setting, setting.times * cases));
      if (!json) print(rows.back());
    }
  }
  if (json) fmt::print("{}\n", rows.dump());
}
