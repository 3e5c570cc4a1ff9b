// How often the truth is among the points that an estimator names: random contacts of 10 N behind at least five joints, and what noise, bias, a wrong friction
// few samples and coarse surfaces do to it. sensing_recall [CASES [CASES_OF_SWEEPS]] [--json] [--only ESTIMATOR]: without sweeps
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "known_arms.hpp"
#include "sensing_baselines/line_of_action.hpp"
#include "sensing_baselines/metropolis.hpp"
#include "sensing_baselines/particle_filter.hpp"
#include "stiction/core/quantile.hpp"

namespace {

using namespace stiction;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr double kForce = 10;   // [N]
constexpr double kNear = 0.01;  // what counts as found [m]
constexpr int kRays = 4;
constexpr double kFriction = 1;
constexpr double kLeastNoise = 1e-4;  // assumed where there is none [N m]
constexpr int kParticles = 500;       // of the filter: 50 of the research code are on two links
constexpr int kFewer = 8;             // methods that take tens of milliseconds see one case of so many
constexpr int kMeasurements = 30;     // of the same torques that it is given

struct Setting {
  const char* estimator = "gauss_newton";
  double noise = 0;           ///< standard deviation of each torque [N m]
  double bias = 0;            ///< of each torque, with a random sign that stays for a case [N m]
  double friction_ratio = 1;  ///< assumed over true
  int samples = 500;          ///< on each link
  double friction_error = 0;  ///< share by which the assumed friction is said to be too small at most
  int segments = 32;          ///< of the round shapes on which it looks; contacts are on those of 32
};

/// What an estimator says of one measurement: points that it holds for possible, the likeliest first, and how many places they are.
struct Estimate {
  std::vector<sensing::ContactPoint> points;
  int places = 0;
};

/// sense() with one of its methods, or a baseline. These search with at least the noise of the research code, as their likelihood is as narrow as it.
class Estimator {
 public:
  Estimator(std::shared_ptr<const sensing::Sensor> sensor, const Setting& setting)
      : sensor_(std::move(sensor)), name_(setting.estimator), work_(sensor_) {
    options_.cone = sensing::FrictionCone(setting.friction_ratio * kFriction, kRays);
    options_.noise = std::max(std::hypot(setting.noise, setting.bias), kLeastNoise);
    options_.friction_error = setting.friction_error;
    if (name_ == "rsgd") options_.method = sensing::SteepestDescent{};
    if (name_ == "rejection") options_.method = sensing::RejectionSampling{};
  }

  void run(const sensing::KnownCase& c, Estimate& out) {
    out.points.clear();
    out.places = 0;
    ++runs_;
    if (name_ == "line_of_action") {
      run_line(c, out);
    } else if (name_ == "particle_filter") {
      run_filter(c, out);
    } else if (name_ == "metropolis") {
      run_chains(c, out);
    } else {
      run_sense(c, out);
    }
  }

 private:
  void run_line(const sensing::KnownCase& c, Estimate& out) const {
    out.points = bench::find_line_of_action(*sensor_, c.q, c.tau, 3 * options_.noise).points;
    out.places = static_cast<int>(out.points.size());
  }

  void run_filter(const sensing::KnownCase& c, Estimate& out) const {
    bench::ParticleFilterOptions options;
    options.cone = options_.cone;
    options.noise = std::max(options_.noise, options.noise);
    options.particles = kParticles;
    options.seed = runs_;
    bench::ParticleFilter filter(sensor_, options);
    for (int i = 1; i < kMeasurements; ++i) (void)filter.update(c.q, c.tau);
    const bench::ParticleEstimate& estimate = filter.update(c.q, c.tau);
    if (!estimate.agrees) return;
    out.points.push_back(estimate.point);
    out.places = 1;
  }

  /// Ends of chains that explain the torques; near each other they are one place.
  void run_chains(const sensing::KnownCase& c, Estimate& out) const {
    bench::MetropolisOptions options;
    options.cone = options_.cone;
    options.noise = std::max(options_.noise, options.noise);
    options.seed = runs_;
    for (const sensing::ContactPoint& point : bench::walk_metropolis(*sensor_, c.q, c.tau, options)) {
      if (point.residual > sensing::calc_noise_bound(options.noise, c.tau.size())) break;
      const double apart = options_.merge * sensor_->links()[static_cast<std::size_t>(point.link)].spacing;
      out.places += std::none_of(out.points.begin(), out.points.end(), [&](const sensing::ContactPoint& other) {
        return other.link == point.link && (other.p_L - point.p_L).norm() <= apart;
      });
      out.points.push_back(point);
    }
  }

  void run_sense(const sensing::KnownCase& c, Estimate& out) {
    sensing::sense(*sensor_, {c.q, c.tau}, options_, work_, result_);
    for (const sensing::Candidate& candidate : result_.candidates) {
      if (!candidate.explains) continue;
      ++out.places;
      for (int i = candidate.first; i < candidate.first + candidate.count; ++i) {
        const sensing::ContactPoint& point = result_.points[static_cast<std::size_t>(i)];
        if (point.residual <= std::max(result_.explained, candidate.best.residual)) out.points.push_back(point);
      }
    }
  }

  std::shared_ptr<const sensing::Sensor> sensor_;
  std::string_view name_;
  std::uint64_t runs_ = 0;  ///< each has random numbers of its own
  sensing::SenseOptions options_;
  sensing::SenseWorkspace work_;
  sensing::SenseResult result_;
};

std::shared_ptr<const sensing::Sensor> make_sensor(const bench::Arm& arm, const Setting& setting) {
  static std::map<std::tuple<std::string, int, int>, std::shared_ptr<const sensing::Sensor>> made;
  auto& out = made[{arm.urdf, setting.samples, setting.segments}];
  if (!out) out = bench::make_sensor(arm, {.samples = setting.samples, .surface = {.segments = setting.segments}});
  return out;
}

Json measure(const bench::Arm& arm, const std::shared_ptr<const sensing::Sensor>& sensor, const Setting& setting, int cases) {
  const std::vector<int> links = bench::links_behind(*sensor, 5);
  Estimator estimator(setting.segments == Setting{}.segments ? sensor : make_sensor(arm, setting), setting);
  Estimate estimate;
  core::Random random(34, 0);
  int near = 0, right = 0, first = 0, several = 0, none = 0;
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
    first += !estimate.points.empty() && estimate.points.front().link == c.contact.link;
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
          {"friction_error", setting.friction_error},
          {"samples", setting.samples},
          {"segments", setting.segments},
          {"cases", cases},
          {"found", share(near)},
          {"right_link", share(right)},
          {"first_link", share(first)},
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
      "{:17} {:13} noise {:4.2f} bias {:4.2f} N m, friction {:4.2f} (error {:3.1f}), {:4} samples, {:2} segments: within 1 cm {:5.1f} %, "
      "right link {:5.1f} %, first {:5.1f} %, several places {:5.1f} %, "
      "none {:5.1f} %, median {:.1f} mm, {:.2f} N, {:.2f} ms, p99 {:.2f} ms\n",
      row["arm"].get<std::string>(), row["estimator"].get<std::string>(), row["noise"].get<double>(), row["bias"].get<double>(),
      row["friction_ratio"].get<double>(), row["friction_error"].get<double>(), row["samples"].get<int>(), row["segments"].get<int>(),
      100 * row["found"].get<double>(), 100 * row["right_link"].get<double>(), 100 * row["first_link"].get<double>(),
      100 * row["several"].get<double>(), 100 * row["none"].get<double>(), 1e3 * row["median_distance_m"].get<double>(),
      row["median_force_error_N"].get<double>(), 1e3 * row["median_s"].get<double>(), 1e3 * row["p99_s"].get<double>());
}

const std::vector<Setting> kSettings = {{"gauss_newton"},
                                        {"gauss_newton", 0, 0, 1, 2000},
                                        {"rsgd"},
                                        {"rejection"},
                                        {"particle_filter"},
                                        {"metropolis"},
                                        {"line_of_action"},
                                        {"gauss_newton", 0.1, 0, 0.7},
                                        {"gauss_newton", 0.1, 0, 0.7, 500, 0.3},
                                        {"particle_filter", 0.1, 0, 0.7},
                                        {"metropolis", 0.1, 0, 0.7},
                                        {"line_of_action", 0.1, 0, 0.7}};

/// One quantity at a time, with some noise in all of them.
std::vector<Setting> make_sweeps() {
  std::vector<Setting> out;
  for (const double noise : {0.01, 0.03, 0.1, 0.3}) out.push_back({"gauss_newton", noise});
  for (const double bias : {0.01, 0.03, 0.1, 0.3}) out.push_back({"gauss_newton", 0.03, bias});
  for (const double ratio : {0.5, 0.7, 0.85, 1.2, 1.5}) out.push_back({"gauss_newton", 0.03, 0, ratio});
  for (const int samples : {20, 50, 100, 200, 1000}) out.push_back({"gauss_newton", 0.03, 0, 1, samples});
  for (const int segments : {6, 8, 12, 20}) out.push_back({"gauss_newton", 0.03, 0, 1, 500, 0, segments});
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> counts;
  bool json = false;
  std::string_view only;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--json")
      json = true;
    else if (std::string_view(argv[i]) == "--only" && i + 1 < argc)
      only = argv[++i];
    else
      counts.push_back(std::max(1, std::atoi(argv[i])));
  }
  const int cases = counts.empty() ? 1000 : counts[0], sweep_cases = counts.size() > 1 ? counts[1] : std::max(1, cases / 5);
  Json rows = Json::array();
  const auto add = [&](const bench::Arm& arm, const std::shared_ptr<const sensing::Sensor>& sensor, const Setting& setting, int n,
                       bool swept) {
    rows.push_back(measure(arm, sensor, setting, n));
    rows.back()["swept"] = swept;
    if (!json) print(rows.back());
  };
  for (const bench::Arm& arm : bench::list_arms()) {
    for (const Setting& setting : kSettings) {
      const std::string_view name = setting.estimator;
      if (!only.empty() && only != name) continue;
      const bool is_slow = name == "rsgd" || name == "particle_filter" || name == "metropolis";
      add(arm, make_sensor(arm, setting), setting, is_slow ? std::max(1, cases / kFewer) : cases, false);
    }
  }
  for (Setting setting : only.empty() ? make_sweeps() : std::vector<Setting>{}) {
    const int segments = std::exchange(setting.segments, Setting{}.segments);
    const auto sensor = make_sensor(bench::kCapsules, setting);
    setting.segments = segments;
    add(bench::kCapsules, sensor, setting, sweep_cases, true);
  }
  if (json) fmt::print("{}\n", rows.dump());
}
