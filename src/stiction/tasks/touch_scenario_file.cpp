#include "stiction/tasks/touch_scenario_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stiction/tasks/arm_section.hpp"
#include "stiction/world/read.hpp"

namespace stiction::tasks {

using execution::ContactSource;
using execution::TouchScenario;
using execution::UnknownBody;
using world::YamlNode;

namespace {

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

}  // namespace stiction::tasks
