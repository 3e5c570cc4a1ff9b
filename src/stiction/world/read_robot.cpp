#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/mjcf.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/scene_sections.hpp"
#include "stiction/world/srdf.hpp"
#include "stiction/world/urdf.hpp"

namespace stiction::world {
namespace {

/// Reads a map from names to numbers. With `all_positive` they must be > 0, and a single number may stand for all names.
std::vector<std::pair<std::string, double>> read_per_name(const YamlNode& node, std::string_view what, std::span<const std::string> known,
                                                          bool all_positive) {
  std::vector<std::pair<std::string, double>> out;
  if (node.is_map()) {
    for (const auto& [name, value] : node.entries()) {
      if (std::find(known.begin(), known.end(), name) == known.end()) value.fail_unknown(what, name, known);
      out.emplace_back(name, all_positive ? value.positive() : value.nonnegative());
    }
  } else if (all_positive) {
    const double value = node.positive();
    for (const auto& name : known) out.emplace_back(name, value);
  } else {
    node.fail(fmt::format("a map from {} to number", what));
  }
  return out;
}

/// Reads efforts: one number for all joints, a list in the order of the joints, or a map for some joints; null means no limit.
std::vector<std::pair<std::string, double>> read_efforts(const YamlNode& node, std::span<const std::string> joints) {
  const auto effort = [](const YamlNode& value) {
    return value.kind() == YamlNode::Kind::Null ? std::numeric_limits<double>::infinity() : value.positive();
  };
  std::vector<std::pair<std::string, double>> out;
  if (node.is_map()) {
    for (const auto& [name, value] : node.entries()) {
      if (std::find(joints.begin(), joints.end(), name) == joints.end()) value.fail_unknown("joint", name, joints);
      out.emplace_back(name, effort(value));
    }
  } else if (node.kind() == YamlNode::Kind::Sequence) {
    const auto values = node.items(joints.size());
    for (std::size_t i = 0; i < joints.size(); ++i) out.emplace_back(joints[i], effort(values[i]));
  } else {
    for (const auto& name : joints) out.emplace_back(name, effort(node));
  }
  return out;
}

/// Rejects keys that the robot's file format does not allow in the scene.
void require_urdf_keys(const YamlNode& node, bool mjcf) {
  if (!mjcf && node.has("fixed_base")) node.at("fixed_base").fail("fixed_base beside urdf", "it only for MJCF, whose bases may be free");
  if (!mjcf) return;
  for (const std::string_view key :
       {"urdf", "package_dirs", "friction", "torsional_friction", "rolling_friction", "convex_hulls", "convex_decomposition"}) {
    if (node.has(key)) node.at(key).fail(fmt::format("{} beside mjcf", key), "it only for URDF robots");
  }
}

/// Largest text of a robot [bytes]. A text contains the whole robot except its meshes; the largest public robot has 1 MB.
constexpr std::size_t kLargestText = 16u << 20;

/// True for a value that begins like XML, so that it is no path.
bool is_xml(std::string_view value) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (value.starts_with(kByteOrderMark)) value.remove_prefix(kByteOrderMark.size());
  const auto first = value.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && value[first] == '<';
}

/// Quotes the beginning of the value given as a path.
std::string quote(std::string_view value) {
  constexpr std::size_t kMost = 80;
  const auto end = std::min(value.find('\n'), kMost);
  return end < value.size() ? fmt::format("'{}…'", value.substr(0, end)) : fmt::format("'{}'", value);
}

/// Reads the key that gives the file or the text of a robot.
void read_source(const YamlNode& value, bool mjcf, RobotSpec& robot) {
  const std::string given = value.string();
  const std::filesystem::path folder = value.file().parent_path();
  std::filesystem::path& file = mjcf ? robot.mjcf : robot.urdf;
  if (is_xml(given)) {
    if (given.size() > kLargestText)
      value.fail(fmt::format("a text of {} bytes", given.size()), fmt::format("{} bytes at most, or a file", kLargestText));
    robot.text = given;
    file = (folder.empty() ? "." : folder) / "";
    return;
  }
  file = find_resource(given, folder, robot.package_dirs);
  if (file.empty())
    value.fail(fmt::format("{}, which does not exist", quote(given)), robot.split.by_actuators ? "an MJCF or URDF file, or its text"
                                                                      : mjcf                   ? "an MJCF file, or its text"
                                                                                               : "a URDF file, or its text");
}

/// True if a whole scene, as file or text, is a URDF.
bool is_whole_urdf(const YamlNode& value, std::span<const std::filesystem::path> package_dirs) {
  const std::string given = value.string();
  if (is_xml(given)) {
    std::istringstream text(given);
    return find_root(text) == "robot";
  }
  const auto file = find_resource(given, value.file().parent_path(), package_dirs);
  return !file.empty() && is_urdf(file);
}

/// Reads the contents of a robot. Messages about a text name the key that contains it.
std::shared_ptr<const RobotContents> read_contents(const YamlNode& source, const RobotSpec& robot) {
  try {
    return contents_of(robot);
  } catch (const core::InvalidInput& e) {
    if (robot.text.empty() && robot.mounts.empty() && !robot.split.by_actuators) throw;
    const std::string where = source.where() + ": ";
    std::string message = where + e.what();
    for (auto at = message.find('\n'); at != std::string::npos; at = message.find('\n', at + where.size())) message.insert(at + 1, where);
    throw core::InvalidInput(message);
  }
}

/// Names the robot of a whole scene "robot", or the like if an object of the file has that name.
void set_name(RobotSpec& robot) {
  const auto is_taken = [&](const std::string& name) {
    return std::ranges::find(robot.contents->objects, name, &ObjectSpec::name) != robot.contents->objects.end();
  };
  robot.name = "robot";
  while (is_taken(robot.name) || is_taken(name_of_fixed(robot))) robot.name += "_";
}

/// Reads the files mounted on links: one map, or a list of maps.
std::vector<MountSpec> read_mounts(const YamlNode& node, const RobotSpec& robot) {
  std::vector<MountSpec> out;
  for (const YamlNode& item : node.is_sequence() ? node.items() : std::vector{node}) {
    item.require_map({"name", "file", "on", "pose"});
    MountSpec mount;
    if (item.has("name")) mount.name = read_name(item);
    const YamlNode file = item.at("file");
    mount.file = find_resource(file.string(), file.file().parent_path(), robot.package_dirs);
    if (mount.file.empty()) file.fail(fmt::format("{}, which does not exist", quote(file.string())), "a URDF or MJCF file");
    mount.on = item.at("on").string();
    if (const auto pose = item.find("pose")) mount.X_LM = read_pose(*pose);
    out.push_back(std::move(mount));
  }
  if (out.empty()) node.fail("an empty list", "files that are mounted");
  return out;
}

/// Reads a list of at least one body name.
std::vector<std::string> read_bodies(const YamlNode& node) {
  std::vector<std::string> out;
  for (const YamlNode& item : node.items()) out.push_back(item.string());
  if (out.empty()) node.fail("an empty list", "bodies of the file");
  return out;
}

/// Reads the keys of a robot, without the contents of its file. @param whole  file of a whole scene, if `node` is the robot of that scene
RobotSpec read_robot(const YamlNode& node, std::span<const std::filesystem::path> package_dirs, const WholeScene* whole) {
  RobotSpec robot;
  const bool mjcf = whole != nullptr ? !is_whole_urdf(whole->file, package_dirs) : node.has("mjcf");
  if (whole != nullptr) {
    node.require_map({"name", "bodies", "srdf", "base", "stiffness", "effort", "link_friction", "push_with", "fixed_base", "mount"});
    if (node.has("name")) robot.name = read_name(node);
    robot.split = {.by_actuators = true, .robot = {}, .objects = whole->objects};
    if (const auto bodies = node.find("bodies")) robot.split.robot = read_bodies(*bodies);
  } else {
    node.require_map({"name", "urdf", "mjcf", "srdf", "package_dirs", "base", "stiffness", "effort", "friction", "torsional_friction",
                      "rolling_friction", "link_friction", "push_with", "convex_hulls", "convex_decomposition", "fixed_base", "mount"});
    robot.name = read_name(node);
  }
  require_urdf_keys(node, mjcf);
  if (const auto dirs = node.find("package_dirs")) {
    for (const YamlNode& dir : dirs->items()) robot.package_dirs.push_back(dir.file().parent_path() / dir.string());
  }
  robot.package_dirs.insert(robot.package_dirs.end(), package_dirs.begin(), package_dirs.end());
  read_source(whole != nullptr ? whole->file : node.at(mjcf ? "mjcf" : "urdf"), mjcf, robot);
  if (const auto base = node.find("base")) robot.X_WBase = read_pose(*base);
  robot.friction = node.nonnegative_or("friction", 1.0);
  robot.rule = read_surface_rule(node, {});
  robot.convex_hulls = node.boolean_or("convex_hulls", false);
  robot.decomposition = read_decomposition(node, "convex_hulls");
  robot.fixed_base = node.boolean_or("fixed_base", false);
  if (const auto mount = node.find("mount")) robot.mounts = read_mounts(*mount, robot);
  return robot;
}

/// Turns the pairs that an SRDF file disables into filters. Its links are all bodies of the robot's file, but not the world of an MJCF.
void add_srdf(const YamlNode& node, RobotSpec& robot, Scene& scene) {
  const auto file = find_resource(node.string(), node.file().parent_path(), robot.package_dirs);
  if (file.empty()) node.fail(fmt::format("'{}', which does not exist", node.string()), "an SRDF file");
  Srdf srdf = read_srdf(file);
  const RobotContents& contents = *robot.contents;
  std::vector<std::string> links;
  for (const RobotLink& link : contents.robot.links) links.push_back(link.name);
  if (!robot.mjcf.empty()) links.erase(links.begin());
  for (const auto& [body, shapes] : contents.shapes_of) {
    if (std::ranges::find(contents.robot.links, body, &RobotLink::name) == contents.robot.links.end()) links.push_back(body);
  }
  for (const auto& [a, b] : srdf.pairs_apart(links)) keep_apart(scene, robot, contents, a, b);
  robot.notes.insert(robot.notes.end(), srdf.notes.begin(), srdf.notes.end());
}

}  // namespace

void read_robot_into(const YamlNode& node, std::span<const std::filesystem::path> package_dirs, Scene& scene,
                     std::vector<std::string>& names, const WholeScene* whole) {
  RobotSpec robot = read_robot(node, package_dirs, whole);
  const YamlNode source = !robot.mounts.empty() && robot.text.empty() ? node.at("mount")
                          : whole != nullptr                          ? whole->file
                                                                      : node.at(robot.mjcf.empty() ? "urdf" : "mjcf");
  robot.contents = read_contents(source, robot);
  if (whole != nullptr && !node.has("name")) set_name(robot);
  const RobotTree& tree = robot.contents->robot;
  std::vector<std::string> links;
  for (const auto& link : tree.links) {
    links.push_back(link.name);
    names.push_back(fmt::format("{}/{}", robot.name, link.name));
    for (const auto& collision : link.collisions) names.push_back(fmt::format("{}/{}/{}", robot.name, link.name, collision.name));
  }
  if (const auto stiffness = node.find("stiffness")) robot.stiffness = read_per_name(*stiffness, "joint", tree.movable_joints(), true);
  if (const auto effort = node.find("effort")) robot.effort = read_efforts(*effort, tree.movable_joints());
  if (const auto friction = node.find("link_friction")) robot.link_friction = read_per_name(*friction, "link", links, false);
  if (const auto list = node.find("push_with")) {
    for (const YamlNode& item : list->items()) {
      robot.push_with.push_back(item.string());
      const auto matches = [&](const std::string& link) { return matches_pattern(robot.push_with.back(), link); };
      if (std::none_of(links.begin(), links.end(), matches)) item.fail_unknown("link", robot.push_with.back(), links);
    }
    if (robot.push_with.empty()) list->fail("an empty list", "the links that may touch objects");
  }
  if (const auto srdf = node.find("srdf")) add_srdf(*srdf, robot, scene);
  if (robot.mjcf.empty() && whole == nullptr)
    scene.robots.push_back(std::move(robot));
  else
    add_mjcf(scene, robot);
}

}  // namespace stiction::world
