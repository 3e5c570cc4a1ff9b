#include <fmt/format.h>

#include <algorithm>

#include "stiction/world/mjcf.hpp"

namespace stiction::world {
namespace {

bool is_object(const RobotContents& contents, const std::string& name) {
  return std::ranges::find(contents.objects, name, &ObjectSpec::name) != contents.objects.end();
}

/// Name in the scene of a body of the file, or of its geometry.
std::string full_name(const RobotSpec& robot, const RobotContents& contents, const std::string& name) {
  const std::string body = name.substr(0, name.find('/'));
  if (is_object(contents, body)) return name;
  return body == "world" ? fmt::format("{}_{}", robot.name, name) : fmt::format("{}/{}", robot.name, name);
}

/// Names in the scene that together stand for the shapes of a body of the file: its link, a whole object or fixed body, or single shapes.
std::vector<std::string> names_of(const RobotSpec& robot, const RobotContents& contents, const std::string& body) {
  std::vector<std::string> out;
  const auto& links = contents.robot.links;
  const auto link = std::ranges::find(links, body, &RobotLink::name);
  const bool is_world = !robot.mjcf.empty() && link == links.begin();
  if (link != links.end() && !is_world) out.push_back(fmt::format("{}/{}", robot.name, body));
  const auto found = std::ranges::find_if(contents.shapes_of, [&](const auto& entry) { return entry.first == body; });
  if (found == contents.shapes_of.end()) return out;
  const std::vector<std::string>& shapes = found->second;
  const std::string holder = shapes[0].substr(0, shapes[0].find('/'));
  const auto object = std::ranges::find(contents.objects, holder, &ObjectSpec::name);
  const auto& all = object != contents.objects.end() ? object->geometries : contents.fixed;
  if (shapes.size() == all.size() && std::ranges::all_of(shapes, [&](const auto& shape) { return shape.starts_with(holder + "/"); })) {
    out.push_back(full_name(robot, contents, holder));
    return out;
  }
  for (const std::string& shape : shapes) out.push_back(full_name(robot, contents, shape));
  return out;
}

}  // namespace

void keep_apart(Scene& scene, const RobotSpec& robot, const RobotContents& contents, const std::string& a, const std::string& b) {
  const std::vector<std::string> others = names_of(robot, contents, b);
  for (const std::string& one : names_of(robot, contents, a)) {
    for (const std::string& other : others) scene.filters.push_back({one, other, std::nullopt});
  }
}

void add_mjcf(Scene& scene, const RobotSpec& robot) {
  const std::shared_ptr<const RobotContents> model = contents_of(robot);
  scene.robots.push_back(robot);
  scene.robots.back().contents = model;
  for (const auto& [a, b] : model->excludes) keep_apart(scene, robot, *model, a, b);
  for (ContactSpec contact : model->contacts) {
    contact.a = full_name(robot, *model, contact.a), contact.b = full_name(robot, *model, contact.b);
    scene.contacts.push_back(std::move(contact));
  }
  const auto set_file = [&](std::vector<GeometrySpec>& geometries) {
    for (GeometrySpec& geometry : geometries) geometry.mask.file = robot.name + "/";
  };
  for (ObjectSpec object : model->objects) {
    set_file(object.geometries);
    if (object.joint != ObjectJoint::Free && object.parent.empty()) object.X_WP = robot.X_WBase * object.X_WP;
    scene.objects.push_back(std::move(object));
  }
  if (model->fixed.empty()) return;
  scene.fixed.push_back({name_of_fixed(robot), robot.X_WBase, model->fixed});
  set_file(scene.fixed.back().geometries);
}

}  // namespace stiction::world
