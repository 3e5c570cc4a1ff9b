#include <fmt/format.h>

#include <algorithm>

#include "stiction/world/mjcf.hpp"

namespace stiction::world {

void add_mjcf(Scene& scene, const RobotSpec& robot) {
  const std::shared_ptr<const RobotContents> model = contents_of(robot);
  scene.robots.push_back(robot);
  scene.robots.back().contents = model;
  const std::string fixed = robot.name + "_world";
  const auto is_object = [&](const std::string& name) {
    return std::any_of(model->objects.begin(), model->objects.end(), [&](const ObjectSpec& object) { return object.name == name; });
  };
  const auto full = [&](const std::string& body) {
    if (body == "world" || body.starts_with("world/")) return fixed + body.substr(5);
    return is_object(body) ? body : fmt::format("{}/{}", robot.name, body);
  };
  const auto full_geometry = [&](const std::string& name) {
    const std::size_t slash = name.find('/');
    return full(name.substr(0, slash)) + name.substr(slash);
  };
  for (const auto& [a, b] : model->excludes) {
    if ((a == "world" || b == "world") && model->fixed.empty()) continue;
    scene.filters.push_back({full(a), full(b), std::nullopt});
  }
  for (ContactSpec contact : model->contacts) {
    contact.a = full_geometry(contact.a), contact.b = full_geometry(contact.b);
    scene.contacts.push_back(std::move(contact));
  }
  for (ObjectSpec object : model->objects) {
    if (object.joint != ObjectJoint::Free && object.parent.empty()) object.X_WP = robot.X_WBase * object.X_WP;
    scene.objects.push_back(std::move(object));
  }
  if (!model->fixed.empty()) scene.fixed.push_back({fixed, robot.X_WBase, model->fixed});
}

}  // namespace stiction::world
