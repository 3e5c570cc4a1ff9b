// How often the truth is among the candidates: random contacts of 10 N behind at least five joints. sensing_recall [CASES]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "stiction/sensing/scenario.hpp"
#include "stiction/world/read.hpp"

namespace {

using namespace stiction;

struct Arm {
  const char* name;
  const char* urdf;
};
constexpr Arm kArms[] = {{"ur5", "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"},
                         {"panda", "package://example-robot-data/robots/panda_description/urdf/panda.urdf"},
                         {"iiwa of capsules", "models/iiwa_primitives.urdf"}};

struct Setting {
  const char* name;
  sensing::Method method;
  double noise;           ///< of the torques [N·m]
  double friction_ratio;  ///< assumed over true
};
const Setting kSettings[] = {{"gauss_newton", sensing::GaussNewton{}, 0, 1},
                             {"rsgd", sensing::SteepestDescent{}, 0, 1},
                             {"gauss_newton, 0.1 N m, friction 30 % too low", sensing::GaussNewton{}, 0.1, 0.7}};

void measure(const Arm& arm, const sensing::Sensor& sensor, const std::shared_ptr<const sensing::Sensor>& shared, const Setting& setting,
             int cases) {
  std::vector<int> links;
  for (int i = 0; i < static_cast<int>(sensor.links().size()); ++i)
    if (sensor.links()[static_cast<std::size_t>(i)].joints >= 5) links.push_back(i);
  const sensing::FrictionCone truth(1, 4);
  sensing::SenseOptions options;
  options.cone = sensing::FrictionCone(setting.friction_ratio * truth.friction(), 4);
  options.noise = std::max(setting.noise, 1e-4);
  options.method = setting.method;
  sensing::SenseWorkspace work(shared);
  sensing::SenseResult result;
  core::Random random(34, 0);
  int near = 0, link = 0, several = 0, silent = 0;
  std::vector<double> seconds;
  for (int i = 0; i < cases; ++i) {
    sensing::KnownCase c = sensing::make_random_case(sensor, links, truth, 10, random);
    for (double& torque : c.tau) torque += setting.noise * random.normal();
    const auto begin = std::chrono::steady_clock::now();
    sensing::sense(sensor, {c.q, c.tau}, options, work, result);
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    double distance = std::numeric_limits<double>::infinity();
    bool right = false;
    int explaining = 0;
    for (const auto& candidate : result.candidates) {
      if (!candidate.explains) continue;
      ++explaining;
      right |= candidate.best.link == c.contact.link;
      distance = std::min(distance, sensing::calc_distance(result, candidate, c.contact));
    }
    near += distance <= 0.01;
    link += right;
    several += explaining > 1;
    silent += result.verdict == sensing::Verdict::BelowThreshold;
  }
  std::sort(seconds.begin(), seconds.end());
  const auto at = [&](double p) { return 1e3 * seconds[static_cast<std::size_t>(p * static_cast<double>(seconds.size() - 1))]; };
  fmt::print(
      "{:18} {:46} within 1 cm {:5.1f} %  right link {:5.1f} %  several candidates {:5.1f} %  below threshold {:4.1f} %  median {:.2f} ms  "
      "p99 {:.2f} ms\n",
      arm.name, setting.name, 100.0 * near / cases, 100.0 * link / cases, 100.0 * several / cases, 100.0 * silent / cases, at(0.5),
      at(0.99));
}

}  // namespace

int main(int argc, char** argv) {
  const int cases = argc > 1 ? std::max(1, std::atoi(argv[1])) : 1000;
  const std::vector<std::filesystem::path> packages{STICTION_PACKAGE_DIR};
  for (const Arm& arm : kArms) {
    const auto scene = world::parse_scene(fmt::format("robots: [{{name: arm, urdf: '{}'}}]", arm.urdf), STICTION_SOURCE_DIR, packages);
    const auto sensor = sensing::Sensor::make(world::Model::make(scene));
    for (const Setting& setting : kSettings) measure(arm, *sensor, sensor, setting, cases);
  }
}
