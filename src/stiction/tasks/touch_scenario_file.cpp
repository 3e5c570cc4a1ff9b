#include "stiction/tasks/touch_scenario_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stiction/tasks/arm_section.hpp"
#include "stiction/tasks/kind_of_file.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/world/read.hpp"

namespace stiction::tasks {

using execution::ContactSource;
using execution::GuardedMove;
using execution::MisplacedBody;
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

Eigen::Vector3d read_direction(const YamlNode& node) {
  const Eigen::Vector3d out = node.vector3();
  if (!(out.norm() > 0)) node.fail("a direction");
  return out.normalized();
}

/// The name of a fixed body of the scene.
std::string read_fixed_name(const YamlNode& node, const world::Scene& scene) {
  std::vector<std::string> names;
  for (const auto& body : scene.fixed) names.push_back(body.name);
  const std::string name = node.string();
  if (std::find(names.begin(), names.end(), name) == names.end()) node.fail_unknown("fixed body", name, names);
  return name;
}

/// A free object of the scene, by its name.
int read_free_object(const YamlNode& node, const world::Scene& scene) {
  std::vector<std::string> names;
  for (const auto& object : scene.objects) names.push_back(object.name);
  const std::string name = node.string();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) node.fail_unknown("object", name, names);
  const auto index = static_cast<std::size_t>(found - names.begin());
  if (scene.objects[index].joint != world::ObjectJoint::Free) node.fail(fmt::format("'{}', which hangs on a joint", name), "a free object");
  return static_cast<int>(index);
}

MisplacedBody read_misplaced(const YamlNode& node, const world::Scene& scene) {
  node.require_map({"body", "position", "objects"});
  MisplacedBody out{read_fixed_name(node.at("body"), scene), node.at("position").vector3()};
  if (out.position_spread.minCoeff() < 0) node.at("position").fail("three numbers ≥ 0");
  if (const auto objects = node.find("objects"))
    for (const YamlNode& object : objects->items()) out.objects.push_back(read_free_object(object, scene));
  return out;
}

/// F of a key "force", which the bound of the controller must allow.
double read_force(const YamlNode& node, const TouchScenario& scenario) {
  const YamlNode force = node.at("force");
  const double most = scenario.arm.controller.lambda_max;
  if (force.positive() > most) force.fail(fmt::format("at most controller.lambda_max, {} N", most));
  return force.number();
}

GuardedMove::Until read_until(const YamlNode& node, const TouchScenario& scenario) {
  node.require_map({"force", "links"});
  GuardedMove::Until out{.force = read_force(node, scenario)};
  if (const auto links = node.find("links"))
    for (const YamlNode& link : links->items()) out.links.push_back(find_link(*scenario.arm.model, link));
  return out;
}

/// Of a scenario without a tool.
GuardedMove read_joint_move(const YamlNode& node, const TouchScenario& scenario) {
  node.require_map({"name", "posture", "speed", "until"});
  GuardedMove out;
  out.name = node.at("name").string();
  out.posture = read_posture(node.at("posture"), *scenario.arm.model);
  out.speed = node.positive_or("speed", out.speed);
  if (const auto until = node.find("until")) {
    out.until = read_until(*until, scenario);
    if (out.until->links.empty()) until->fail("links, one for each side that is to touch");
  }
  return out;
}

GuardedMove read_move(const YamlNode& node, const TouchScenario& scenario) {
  if (scenario.arm.tool < 0) return read_joint_move(node, scenario);
  node.require_map({"name", "direction", "travel", "speed", "until", "gap", "press", "correct"});
  const world::Scene& scene = scenario.arm.model->scene();
  GuardedMove out;
  out.name = node.at("name").string();
  out.direction_W = read_direction(node.at("direction"));
  out.travel = node.at("travel").positive();
  out.speed = node.positive_or("speed", out.speed);
  if (node.has("until") + node.has("gap") + node.has("press") > 1) node.fail("at most one of until, gap, press");
  if (const auto until = node.find("until")) out.until = read_until(*until, scenario);
  if (const auto gap = node.find("gap")) {
    gap->require_map({"body", "distance"});
    out.gap = {.body = read_fixed_name(gap->at("body"), scene), .distance = gap->at("distance").positive()};
  }
  if (const auto press = node.find("press")) {
    press->require_map({"direction", "force"});
    out.press = {.direction_W = read_direction(press->at("direction")), .force = read_force(*press, scenario)};
  }
  if (const auto correct = node.find("correct")) {
    if (!out.until && !out.press) correct->fail("a move with 'until' or 'press': only what is felt corrects a place");
    out.correct = read_fixed_name(*correct, scene);
  }
  return out;
}

void read_moves(const YamlNode& top, TouchScenario& out) {
  if (const auto tool = top.find("tool")) {
    tool->require_map({"link", "point"});
    out.arm.tool = find_link(*out.arm.model, tool->at("link"));
    if (const auto point = tool->find("point")) out.arm.X_BT.p = point->vector3();
  }
  bool felt = false;
  for (const YamlNode& item : top.at("moves").items()) {
    const GuardedMove& move = out.moves.emplace_back(read_move(item, out));
    if (move.press && !felt) item.at("press").fail("a move after one with 'until', which feels what is pressed on");
    felt = move.until.has_value() || move.press.has_value();
  }
  if (out.moves.empty()) top.at("moves").fail("at least one move");
}

std::vector<std::string> names_of(const world::Scene& scene) {
  std::vector<std::string> out;
  for (const auto& robot : scene.robots) out.push_back(robot.name);
  for (const auto& object : scene.objects) out.push_back(object.name);
  for (const auto& body : scene.fixed) out.push_back(body.name);
  return out;
}

/// Scene and start are those of a task.
void take_scene(const Task& task, execution::ControlScenario& out) {
  const Eigen::VectorXd& q = task.problem.q_start;
  out.model = task.model;
  out.objects = q.head(task.model->n_qu());
  out.start = q.tail(task.model->n_a());
}

/// The task that a scenario names: a built-in one, or a file relative to that of the scenario.
Task load_task_of(const YamlNode& node) {
  const std::string name = node.string();
  return load_task(name.ends_with(".yaml") || name.ends_with(".yml") ? (node.file().parent_path() / name).string() : name);
}

/// @param task  in place of the one that the scenario names; null: that
TouchScenario read_scenario(const YamlNode& top, std::span<const std::filesystem::path> package_dirs, const Task* task = nullptr) {
  refuse_other_kind(top, FileKind::Touch);
  top.require_map({"name", "description", "task", "scene", "start", "goal", "speed", "max_touches", "tolerance", "unknown", "misplaced",
                   "friction_motion", "tool", "moves", "controller", "plant", "estimator"});
  TouchScenario out;
  out.arm.contacts = ContactSource::Estimated;
  if (const auto named = top.find("task")) {
    for (const char* key : {"scene", "start"})
      if (top.has(key)) top.at(key).fail(fmt::format("{} beside task", key), "one of them: a task has a scene and a start");
    take_scene(task ? *task : load_task_of(*named), out.arm);
  } else if (task) {
    top.at("scene").fail("a scene of its own", fmt::format("`task: {}` in place of scene and start", task->name));
  }
  read_arm(top, package_dirs, out.arm);
  if (out.arm.contacts != ContactSource::Estimated)
    top.at("estimator").at("contacts").fail("estimated: this arm feels joint torques alone");
  if (task && top.has("goal")) top.at("goal").fail("a posture to go to", "moves: a run begins with these");
  if (!task && top.has("goal") == top.has("moves")) top.fail("one of goal, moves");
  if (const auto goal = top.find("goal")) out.goal = read_posture(*goal, *out.arm.model);
  if (top.has("moves")) read_moves(top, out);
  if (const auto motion = top.find("friction_motion")) {
    if (out.moves.empty()) motion->fail("friction_motion without moves", "moves, of which guarded ones use it");
    out.friction_motion = motion->positive();
  }
  out.speed = top.positive_or("speed", out.speed);
  out.tolerance = top.positive_or("tolerance", out.tolerance);
  if (const auto most = top.find("max_touches")) out.max_touches = most->positive_int();
  std::vector<std::string> taken = names_of(out.arm.model->scene());
  if (const auto unknown = top.find("unknown"))
    for (const YamlNode& node : unknown->items()) {
      out.unknown.push_back(read_unknown(node, taken));
      taken.push_back(out.unknown.back().body.name);
    }
  if (const auto misplaced = top.find("misplaced"))
    for (const YamlNode& node : misplaced->items()) out.misplaced.push_back(read_misplaced(node, out.arm.model->scene()));
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

TouchScenario load_touch_scenario(const std::filesystem::path& file, const Task& task) {
  TouchScenario out = read_scenario(world::load_yaml_with_base(file), {}, &task);
  out.arm.file = file;
  return out;
}

}  // namespace stiction::tasks
