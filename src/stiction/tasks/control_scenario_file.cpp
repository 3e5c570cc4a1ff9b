#include "stiction/tasks/control_scenario_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stiction/tasks/arm_section.hpp"
#include "stiction/tasks/kind_of_file.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

using execution::ControlScenario;
using execution::HandKnot;
using execution::HandPush;
using execution::ReferenceKnot;
using world::YamlNode;

namespace {

void read_knots(const YamlNode& node, const char* value_key, ControlScenario& out) {
  for (const YamlNode& item : node.items()) {
    ReferenceKnot knot;
    if (out.tool >= 0) {
      item.require_map({"time", "move", "turn"});
      knot.value.setZero(6);
      knot.value.head<3>() = item.at(value_key).vector3();
      if (const auto turn = item.find("turn")) knot.value.tail<3>() = turn->vector3();
    } else {
      item.require_map({"time", "position"});
      knot.value = read_posture(item.at(value_key), *out.model);
    }
    knot.time = item.at("time").nonnegative();
    if (out.knots.empty() && knot.time != 0) item.at("time").fail("0: the first knot is the start");
    if (!out.knots.empty() && !(knot.time > out.knots.back().time))
      item.at("time").fail(fmt::format("more than {} s", out.knots.back().time));
    out.knots.push_back(std::move(knot));
  }
  if (out.knots.empty()) node.fail("at least one knot");
}

void read_reference(const YamlNode& node, ControlScenario& out) {
  node.require_map({"joints", "tool"});
  if (node.has("joints") == node.has("tool")) node.fail("one of joints, tool");
  if (const auto tool = node.find("tool")) {
    tool->require_map({"link", "point", "knots"});
    out.tool = find_link(*out.model, tool->at("link"));
    if (const auto point = tool->find("point")) out.X_BT.p = point->vector3();
    read_knots(tool->at("knots"), "move", out);
    if (!out.knots.front().value.isZero(0)) tool->at("knots").items().front().fail("no displacement in the first knot: it is the start");
    return;
  }
  read_knots(node.at("joints"), "position", out);
}

void read_hand(const YamlNode& node, ControlScenario& out) {
  node.require_map({"link", "direction", "stiffness", "knots"});
  HandPush& hand = out.hand;
  hand.body = find_link(*out.model, node.at("link"));
  hand.direction_W = node.at("direction").vector3();
  if (!(hand.direction_W.norm() > 0)) node.at("direction").fail("a direction");
  hand.direction_W.normalize();
  hand.stiffness = node.at("stiffness").positive();
  for (const YamlNode& item : node.at("knots").items()) {
    item.require_map({"time", "point", "depth"});
    HandKnot knot{item.at("time").nonnegative(), item.at("point").vector3(), item.at("depth").nonnegative()};
    if (hand.knots.empty() && (knot.time != 0 || knot.depth != 0)) item.fail("time 0 and depth 0: the first knot is the start");
    if (!hand.knots.empty() && !(knot.time > hand.knots.back().time))
      item.at("time").fail(fmt::format("more than {} s", hand.knots.back().time));
    hand.knots.push_back(knot);
  }
  if (hand.knots.empty()) node.at("knots").fail("at least one knot");
}

ControlScenario read_scenario(const YamlNode& top, std::span<const std::filesystem::path> package_dirs) {
  refuse_other_kind(top, FileKind::Control);
  top.require_map({"name", "description", "scene", "start", "reference", "hand", "hold", "controller", "plant", "estimator"});
  ControlScenario out;
  read_arm(top, package_dirs, out);
  read_reference(top.at("reference"), out);
  if (const auto hand = top.find("hand")) read_hand(*hand, out);
  const double last = std::max(out.knots.back().time, out.hand.knots.empty() ? 0.0 : out.hand.knots.back().time);
  out.duration = last + top.nonnegative_or("hold", 0);
  if (!(out.duration > 0)) top.at("reference").fail("knots that last longer than 0 s");
  return out;
}

}  // namespace

ControlScenario load_control_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs) {
  ControlScenario out = read_scenario(world::load_yaml_with_base(file), package_dirs);
  out.file = file;
  return out;
}

ControlScenario parse_control_scenario(const std::string& text, const std::filesystem::path& folder,
                                       std::span<const std::filesystem::path> package_dirs) {
  return read_scenario(world::parse_yaml_with_base(text, folder), package_dirs);
}

}  // namespace stiction::tasks
