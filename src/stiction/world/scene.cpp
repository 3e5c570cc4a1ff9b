#include "stiction/world/scene.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stiction/core/faults.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/scene_sections.hpp"

namespace stiction::world {
namespace {

FilterSpec read_filter(const YamlNode& node, std::span<const std::string> names) {
  node.require_map({"exclude", "limit", "max_distance"});
  const bool exclude = node.has("exclude");
  if (exclude == node.has("limit")) node.fail("both or none of exclude and limit", "one of the two");
  const auto pair = node.at(exclude ? "exclude" : "limit").items(2);
  FilterSpec filter{pair[0].string(), pair[1].string(), std::nullopt};
  for (const YamlNode& pattern : pair) {
    const std::string text = pattern.string();
    if (std::none_of(names.begin(), names.end(), [&](const std::string& name) { return matches_pattern(text, name); })) {
      pattern.fail_unknown("body or geometry", text, names);
    }
  }
  if (exclude && node.has("max_distance")) node.at("max_distance").fail("max_distance beside exclude", "it only with limit");
  if (!exclude) filter.max_distance = node.at("max_distance").nonnegative();
  return filter;
}

/// Reads a scene. An error in one entry does not hide errors in the next.
class SceneReader {
 public:
  SceneReader(const YamlNode& node, std::span<const std::filesystem::path> package_dirs) : node_(node), package_dirs_(package_dirs) {}

  Scene read() {
    node_.require_map();
    faults_.collect([&] {
      node_.require_map(
          {"name", "file", "robot", "gravity", "contact_distance", "max_contacts", "robots", "objects", "fixed", "places", "filters"});
    });
    scene_.file = node_.file();
    faults_.collect([&] { scene_.name = node_.string_or("name", node_.file().has_filename() ? node_.file().stem().string() : "scene"); });
    faults_.collect([&] {
      if (const auto gravity = node_.find("gravity")) scene_.gravity = gravity->vector3();
    });
    faults_.collect([&] { scene_.contact_distance = node_.positive_or("contact_distance", scene_.contact_distance); });
    faults_.collect([&] {
      if (const auto most = node_.find("max_contacts")) scene_.max_contacts = most->positive_int();
    });
    faults_.collect([&] { read_whole_scene(); });
    each("objects", [&](const YamlNode& item) {
      if (!item.is_scalar()) read_object_entry(item);
    });
    each("robots", [&](const YamlNode& item) { read_robot_entry(item); });
    each("fixed", [&](const YamlNode& item) {
      scene_.fixed.push_back(read_fixed(item));
      add_owner(item, scene_.fixed.back().name, scene_.fixed.back().geometries);
    });
    faults_.raise();  // places and filters need all names, so earlier faults end the reading here
    faults_.collect([&] {
      if (const auto places = node_.find("places")) read_places(*places);
    });
    each("filters", [&](const YamlNode& item) { scene_.filters.push_back(read_filter(item, names_)); });
    faults_.raise();
    return std::move(scene_);
  }

 private:
  template <class Read>
  void each(std::string_view key, Read&& read) {
    faults_.collect([&] {
      const auto list = node_.find(key);
      if (!list) return;
      for (const YamlNode& item : list->items()) faults_.collect([&] { read(item); });
    });
  }

  /// Reads positions that replace those in the entries of fixed bodies.
  void read_places(const YamlNode& node) {
    for (const auto& [name, position] : node.entries()) {
      const auto body = std::ranges::find(scene_.fixed, name, &FixedSpec::name);
      if (body != scene_.fixed.end()) {
        body->X_WB.p = position.vector3();
        continue;
      }
      std::vector<std::string> known;
      for (const FixedSpec& fixed : scene_.fixed) known.push_back(fixed.name);
      position.fail_unknown("fixed body", name, known);
    }
  }

  void add_owner(const YamlNode& item, const std::string& name, const std::vector<GeometrySpec>& geometries) {
    if (std::find(owners_.begin(), owners_.end(), name) != owners_.end())
      (item.has("name") ? item.at("name") : item).fail(fmt::format("'{}' twice", name), "each name once");
    owners_.push_back(name);
    names_.push_back(name);
    for (const auto& geometry : geometries) names_.push_back(fmt::format("{}/{}", name, geometry.name));
  }

  void read_object_entry(const YamlNode& item) {
    ObjectSpec object;
    if (!faults_.collect([&] { object = read_object(item); })) {
      if (!item.is_map()) return;
      if (const auto name = item.find("name"); name && name->is_scalar())
        owners_.push_back(name->string());  // later objects may hang on it
      return;
    }
    if (!object.parent.empty() && std::find(owners_.begin(), owners_.end(), object.parent) == owners_.end())
      item.at("parent").fail_unknown("object listed before", object.parent, owners_);
    scene_.objects.push_back(std::move(object));
    add_owner(item, scene_.objects.back().name, scene_.objects.back().geometries);
  }

  /// Reads the robot, the objects and the fixed body of a scene that is one file.
  void read_whole_scene() {
    std::vector<YamlNode> words;
    if (const auto objects = node_.find("objects"); objects && objects->is_sequence()) {
      for (const YamlNode& item : objects->items()) {
        if (item.is_scalar()) words.push_back(item);
      }
    }
    const auto file = node_.find("file");
    if (!file) {
      if (const auto robot = node_.find("robot")) robot->fail("robot without file", "`file`, of whose robot it speaks, or `robots`");
      for (const YamlNode& word : words) word.fail("a map: a name stands for a body of `file`, and there is none");
      return;
    }
    WholeScene whole{*file, std::nullopt};
    if (!words.empty()) whole.objects.emplace();
    for (const YamlNode& word : words) whole.objects->push_back(word.string());
    const YamlNode none = YamlNode::parse("{}", node_.file());
    const YamlNode robot = node_.find("robot").value_or(none);
    robot.require_map();
    read_robot_entry(robot, &whole);
    const RobotContents& contents = *scene_.robots.back().contents;
    if (!node_.has("gravity")) scene_.gravity = contents.gravity;
    if (contents.robot.movable_joints().empty() && !node_.has("robots"))
      file->fail("a file without a robot: no joint has an actuator",
                 "a joint with one, `robot: {bodies: […]}` with a body of a tree that is a robot, or `robots`");
  }

  void read_robot_entry(const YamlNode& item, const WholeScene* whole = nullptr) {
    const std::size_t objects = scene_.objects.size(), fixed = scene_.fixed.size();
    read_robot_into(item, package_dirs_, scene_, names_, whole);
    add_owner(item, scene_.robots.back().name, {});
    for (std::size_t i = objects; i < scene_.objects.size(); ++i)  // objects from an MJCF
      add_owner(item, scene_.objects[i].name, scene_.objects[i].geometries);
    for (std::size_t i = fixed; i < scene_.fixed.size(); ++i) add_owner(item, scene_.fixed[i].name, scene_.fixed[i].geometries);
  }

  const YamlNode& node_;
  std::span<const std::filesystem::path> package_dirs_;
  Scene scene_{};
  core::Faults faults_{};
  std::vector<std::string> owners_{}, names_{};
};

}  // namespace

bool matches_pattern(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, resume = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p, ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++resume;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

Scene read_scene(const YamlNode& node, std::span<const std::filesystem::path> package_dirs) {
  return SceneReader(node, package_dirs).read();
}

Scene read_scene_file(const YamlNode& top, std::span<const std::filesystem::path> package_dirs) {
  top.require_map();
  if (!top.has("scene")) return read_scene(top, package_dirs);
  Scene scene = read_scene(top.at("scene"), package_dirs);
  scene.file = top.file();
  if (!top.at("scene").has("name")) scene.name = top.string_or("name", scene.file.has_filename() ? scene.file.stem().string() : scene.name);
  return scene;
}

Scene load_scene(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs) {
  return read_scene_file(load_yaml_with_base(file), package_dirs);
}

Scene parse_scene(const std::string& text, const std::filesystem::path& folder, std::span<const std::filesystem::path> package_dirs) {
  return read_scene_file(parse_yaml_with_base(text, folder), package_dirs);
}

Scene load_scene(const std::filesystem::path& file) { return load_scene(file, {}); }

}  // namespace stiction::world
