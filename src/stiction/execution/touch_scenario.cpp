#include "stiction/execution/touch_scenario.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "stiction/contact/contact.hpp"
#include "stiction/contact/contact_sampler.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::execution {

using world::YamlNode;

namespace {

constexpr std::uint64_t kPlaceStream = 1;  ///< of random numbers; the observer has 0 of the same seed

UnknownBody read_unknown(const YamlNode& node, const std::vector<std::string>& taken) {
  UnknownBody out;
  out.body = world::read_fixed(node.without("spread"));
  if (std::find(taken.begin(), taken.end(), out.body.name) != taken.end())
    node.at("name").fail(fmt::format("'{}', which is taken", out.body.name), "a name of its own");
  if (const auto spread = node.find("spread")) {
    spread->require_map({"position", "yaw"});
    if (const auto position = spread->find("position")) {
      out.position_spread = position->vector3();
      if (out.position_spread.minCoeff() < 0) position->fail("three numbers ≥ 0");
    }
    out.yaw_spread = spread->nonnegative_or("yaw", 0);
  }
  return out;
}

std::vector<std::string> names_of(const world::Scene& scene) {
  std::vector<std::string> out;
  for (const auto& robot : scene.robots) out.push_back(robot.name);
  for (const auto& object : scene.objects) out.push_back(object.name);
  for (const auto& body : scene.fixed) out.push_back(body.name);
  return out;
}

/// The first fixed body that the arm touches at `q_a`; empty: none.
std::string find_touched(const world::Model& model, const Eigen::VectorXd& q_a) {
  contact::GeometryWorkspace work(model);
  Eigen::VectorXd q = model.neutral();
  q.tail(model.n_a()) = q_a;
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  const world::RobotChains chains(model);
  chains.pairs_of(chains.all(), work.pairs);
  contact::query_pairs(model, work.kinematics, work.pairs, 0, work.contact_work, work.contacts);
  if (work.contacts.empty()) return "";
  const world::Pair& pair = model.pairs()[static_cast<std::size_t>(work.contacts.front().pair)];
  return model.geometries()[static_cast<std::size_t>(pair.geometry_b)].name;
}

}  // namespace

namespace {

TouchScenario read_scenario(const YamlNode& top, std::span<const std::filesystem::path> package_dirs) {
  top.require_map({"name", "description", "scene", "start", "goal", "speed", "max_touches", "tolerance", "unknown", "controller", "plant",
                   "estimator"});
  TouchScenario out;
  out.arm.contacts = ContactSource::Estimated;
  read_arm(top, package_dirs, out.arm);
  if (out.arm.contacts != ContactSource::Estimated)
    top.at("estimator").at("contacts").fail("estimated: this arm feels joint torques alone");
  out.goal = read_posture(top.at("goal"), *out.arm.model);
  out.speed = top.positive_or("speed", out.speed);
  out.tolerance = top.positive_or("tolerance", out.tolerance);
  if (const auto most = top.find("max_touches")) out.max_touches = most->positive_int();
  std::vector<std::string> taken = names_of(out.arm.model->scene());
  if (const auto unknown = top.find("unknown"))
    for (const YamlNode& node : unknown->items()) {
      out.unknown.push_back(read_unknown(node, taken));
      taken.push_back(out.unknown.back().body.name);
    }
  return out;
}

}  // namespace

TouchScenario load_touch_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs) {
  TouchScenario out = read_scenario(world::load_yaml_with_base(file), package_dirs);
  out.arm.file = file;
  return out;
}

TouchScenario parse_touch_scenario(const std::string& text, const std::filesystem::path& folder,
                                   std::span<const std::filesystem::path> package_dirs) {
  return read_scenario(world::parse_yaml_with_base(text, folder), package_dirs);
}

std::shared_ptr<const world::Model> make_world(const TouchScenario& scenario, std::uint64_t seed) {
  world::Scene scene = scenario.arm.model->scene();
  core::Random random(seed, kPlaceStream);
  for (const UnknownBody& unknown : scenario.unknown) {
    world::FixedSpec body = unknown.body;
    for (int i = 0; i < 3; ++i) body.X_WB.p[i] += unknown.position_spread[i] * random.uniform(-1, 1);
    const double yaw = unknown.yaw_spread * random.uniform(-1, 1);
    body.X_WB.R = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * body.X_WB.R;
    scene.fixed.push_back(std::move(body));
  }
  auto model = world::Model::make(scene);
  if (const std::string touched = find_touched(*model, scenario.arm.start); !touched.empty())
    core::throw_invalid(scenario.arm.file.empty() ? "start" : fmt::format("{}: start", scenario.arm.file.string()),
                        fmt::format("a posture that touches '{}' (seed {})", touched, seed), "one that touches nothing");
  return model;
}

}  // namespace stiction::execution
