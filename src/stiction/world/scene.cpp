#include "stiction/world/scene.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/mjcf.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/srdf.hpp"
#include "stiction/world/urdf.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::world {

namespace {

constexpr double kQuaternionTolerance = 1e-3;  ///< files round quaternions; the reader normalises
constexpr double kCenterTolerance = 1e-6;      ///< [m]

Eigen::Matrix3d read_rotation(const YamlNode& node) {
  const auto quaternion = node.find("quaternion_wxyz");
  const auto rpy = node.find("rpy");
  if (quaternion && rpy) rpy->fail("rpy beside quaternion_wxyz", "one of the two");
  if (rpy) return rotation_from_rpy(rpy->vector3());
  if (!quaternion) return Eigen::Matrix3d::Identity();
  const Eigen::Vector4d wxyz = quaternion->vector(4);
  if (!(std::abs(wxyz.norm() - 1) <= kQuaternionTolerance)) {
    quaternion->fail(fmt::format("a quaternion of length {:.6g}", wxyz.norm()), "length 1");
  }
  return Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix();
}

std::string read_name(const YamlNode& node) {
  const YamlNode value = node.at("name");
  std::string name = value.string();
  if (name.find_first_of("/* \t\n") != std::string::npos) value.fail("a name without '/', '*' or spaces");
  return name;
}

std::optional<Decomposition> read_decomposition(const YamlNode& node, std::string_view hull_key) {
  const auto found = node.find("convex_decomposition");
  if (!found) return std::nullopt;
  Decomposition out;
  if (found->is_map()) {
    found->require_map({"threshold", "max_parts"});
    out.threshold = found->number_or("threshold", out.threshold);
    if (!(out.threshold >= Decomposition::kMinThreshold && out.threshold <= 1)) found->at("threshold").fail("a number from 0.01 to 1");
    if (const auto parts = found->find("max_parts")) out.max_parts = parts->positive_int();
  } else if (!found->is_scalar()) {
    found->fail("true, false or a map with threshold and max_parts");
  } else if (!found->boolean()) {
    return std::nullopt;
  }
  if (node.boolean_or(hull_key, false)) found->fail(fmt::format("convex_decomposition beside {}", hull_key), "one of the two");
  return out;
}

/// The convex parts of a mesh file: of one that is not convex several.
std::vector<Shape> read_mesh(const YamlNode& node) {
  node.require_map({"file", "scale", "convex_hull", "convex_decomposition"});
  const YamlNode file = node.at("file");
  const auto path = find_resource(file.string(), file.file().parent_path(), {});
  if (path.empty()) file.fail(fmt::format("'{}', which does not exist", file.string()), "a mesh file");
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  if (const auto given = node.find("scale")) scale = given->is_sequence() ? given->vector3() : Eigen::Vector3d::Constant(given->positive());
  MeshOptions options;
  if (node.boolean_or("convex_hull", false)) options.non_convex = NonConvex::TakeHull;
  if (const auto decomposition = read_decomposition(node, "convex_hull")) options.decomposition = *decomposition;
  std::vector<Shape> shapes;
  try {
    for (ConvexMesh& part : load_mesh(path, scale, options).parts)
      shapes.emplace_back(Mesh{std::make_shared<const ConvexMesh>(std::move(part))});
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", file.where(), e.what()));
  }
  return shapes;
}

/// One shape, or the convex parts of a mesh.
std::vector<Shape> read_shape(const YamlNode& node, std::string_view kind, bool half_space_allowed) {
  if (kind == "sphere") {
    node.require_map({"radius"});
    return {Sphere{node.at("radius").positive()}};
  }
  if (kind == "box") {
    node.require_map({"size"});
    const Eigen::Vector3d size = node.at("size").vector3();
    if (!(size.minCoeff() > 0)) node.at("size").fail(fmt::format("{}, {}, {}", size[0], size[1], size[2]), "three numbers > 0");
    return {Box{size / 2}};
  }
  if (kind == "capsule" || kind == "cylinder") {
    node.require_map({"radius", "length"});
    const double radius = node.at("radius").positive(), half_length = node.at("length").positive() / 2;
    if (kind == "capsule") return {Capsule{radius, half_length}};
    return {Cylinder{radius, half_length}};
  }
  if (kind == "half_space") {
    if (!half_space_allowed) node.fail("a half-space", "a shape with a finite volume (half-spaces are for fixed bodies)");
    if (node.kind() != YamlNode::Kind::Null) node.require_map({});
    return {HalfSpace{}};
  }
  return read_mesh(node);
}

std::vector<GeometrySpec> read_geometries(const YamlNode& node, double friction, bool half_space_allowed) {
  static constexpr std::string_view kKinds[] = {"sphere", "box", "capsule", "cylinder", "mesh", "half_space"};
  std::vector<GeometrySpec> out;
  int number = 0;  ///< of the shape, in names that are not given
  for (const YamlNode& item : node.at("shapes").items()) {
    item.require_map({"name", "pose", "friction", "sphere", "box", "capsule", "cylinder", "mesh", "half_space"});
    std::vector<Shape> shapes;
    int found = 0;
    for (const std::string_view kind : kKinds) {
      if (!item.has(kind)) continue;
      ++found;
      shapes = read_shape(item.at(kind), kind, half_space_allowed);
    }
    if (found != 1) item.fail(fmt::format("{} shapes", found), "exactly one of sphere, box, capsule, cylinder, mesh, half_space");
    const std::string name = item.string_or("name", fmt::format("{}_{}", shape_name(shapes[0]), number));
    ++number;
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      GeometrySpec geometry{.name = part_name(name, k, shapes.size()), .shape = shapes[k], .X_BG = {}};
      for (const auto& other : out) {
        if (other.name == geometry.name) item.fail(fmt::format("the name '{}' twice", geometry.name), "each name once");
      }
      if (const auto pose = item.find("pose")) geometry.X_BG = read_pose(*pose);
      geometry.friction = item.nonnegative_or("friction", friction);
      out.push_back(std::move(geometry));
    }
  }
  if (out.empty()) node.at("shapes").fail("at least one shape");
  return out;
}

Eigen::Vector3d read_axis(const YamlNode& node) {
  const Eigen::Vector3d axis = node.vector3();
  if (!(axis.norm() > 1e-6)) node.fail("0, 0, 0", "an axis other than 0");
  return axis.normalized();
}

void read_mass(const YamlNode& node, ObjectSpec& object) {
  object.mass = node.at("mass").positive();
  if (!object.geometries.empty()) {
    const VolumeProperties shape = calc_volume_properties(object.geometries);
    object.p_BCom = shape.center;
    object.inertia = object.mass / shape.volume * shape.inertia;
  }
  if (const auto inertia = node.find("inertia")) {
    const Eigen::Vector3d moments = inertia->vector3();
    if (!(moments.minCoeff() > 0)) inertia->fail(fmt::format("{}, {}, {}", moments[0], moments[1], moments[2]), "three numbers > 0");
    const double largest = moments.maxCoeff();
    if (largest > (1 + 1e-9) * (moments.sum() - largest)) {  // ∫(y² + z²) dm ≤ ∫(z² + x²) dm + ∫(x² + y²) dm
      inertia->fail(fmt::format("{}, {}, {}", moments[0], moments[1], moments[2]),
                    "moments that a body can have: none larger than the other two together");
    }
    object.inertia = moments.asDiagonal();
    if (const auto center = node.find("center_of_mass")) object.p_BCom = center->vector3();
  } else if (const auto center = node.find("center_of_mass")) {
    center->fail("center_of_mass without inertia", "both (or neither: they follow from the shapes)");
  }
  if (object.p_BCom.norm() < kCenterTolerance) object.p_BCom.setZero();
  if (object.joint == ObjectJoint::Free && !object.p_BCom.isZero()) {
    node.at("shapes").fail(
        fmt::format("shapes whose centre of mass lies at ({:.6g}, {:.6g}, {:.6g})", object.p_BCom[0], object.p_BCom[1], object.p_BCom[2]),
        "it at the origin of a free object (shift the poses of the shapes by minus that)");
  }
}

ObjectSpec read_object(const YamlNode& node) {
  node.require_map({"name", "parent", "joint", "axis", "pose", "mass", "inertia", "center_of_mass", "friction", "limits", "shapes"});
  ObjectSpec object;
  object.name = read_name(node);
  static constexpr std::string_view kJoints[] = {"free", "planar_xy", "planar_yz", "planar_xz", "hinge", "slider"};
  const std::string joint = node.at("joint").one_of(kJoints);
  object.joint = static_cast<ObjectJoint>(std::find(std::begin(kJoints), std::end(kJoints), joint) - std::begin(kJoints));
  object.parent = node.string_or("parent", "");
  const bool single = object.joint == ObjectJoint::Hinge || object.joint == ObjectJoint::Slider;
  if (single) object.axis = read_axis(node.at("axis"));
  for (const std::string_view key : {"axis", "limits", "parent"}) {
    if (!single && node.has(key)) node.at(key).fail(fmt::format("{} of a {} object", key, joint), "it only for hinge and slider objects");
  }
  if (const auto pose = node.find("pose")) {
    if (object.joint == ObjectJoint::Free) pose->fail("pose of a free object", "none (where it starts is part of the start)");
    object.X_WP = read_pose(*pose);
  }
  if (const auto limits = node.find("limits")) {
    const Eigen::Vector2d range = limits->vector(2);
    if (!(range[0] <= range[1])) limits->fail(fmt::format("[{}, {}]", range[0], range[1]), "lower ≤ upper");
    object.limits = {range[0], range[1]};
  }
  if (node.has("shapes") || !node.has("inertia")) object.geometries = read_geometries(node, node.nonnegative_or("friction", 1.0), false);
  read_mass(node, object);
  return object;
}

/// A map from names to numbers; `all_positive`: they are > 0, and one number stands for every name.
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

/// One number for all joints, a list in their order, or a map for some; null for no limit.
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

/// What is said in the file of the robot and cannot be said again beside it.
void require_urdf_keys(const YamlNode& node, bool mjcf) {
  if (!mjcf) return;
  for (const std::string_view key : {"urdf", "package_dirs", "friction", "convex_hulls", "convex_decomposition"}) {
    if (node.has(key)) node.at(key).fail(fmt::format("{} beside mjcf", key), "it only for URDF robots");
  }
}

/// The robot without what its own file says.
RobotSpec read_robot(const YamlNode& node, std::span<const std::filesystem::path> package_dirs) {
  node.require_map({"name", "urdf", "mjcf", "srdf", "package_dirs", "base", "stiffness", "effort", "friction", "link_friction", "push_with",
                    "convex_hulls", "convex_decomposition"});
  RobotSpec robot;
  robot.name = read_name(node);
  const bool mjcf = node.has("mjcf");
  require_urdf_keys(node, mjcf);
  if (const auto dirs = node.find("package_dirs")) {
    for (const YamlNode& dir : dirs->items()) robot.package_dirs.push_back(dir.file().parent_path() / dir.string());
  }
  robot.package_dirs.insert(robot.package_dirs.end(), package_dirs.begin(), package_dirs.end());
  const YamlNode file = node.at(mjcf ? "mjcf" : "urdf");
  const auto found = find_resource(file.string(), file.file().parent_path(), robot.package_dirs);
  if (found.empty()) file.fail(fmt::format("'{}', which does not exist", file.string()), mjcf ? "an MJCF file" : "a URDF file");
  (mjcf ? robot.mjcf : robot.urdf) = found;
  if (const auto base = node.find("base")) robot.X_WBase = read_pose(*base);
  robot.friction = node.nonnegative_or("friction", 1.0);
  robot.convex_hulls = node.boolean_or("convex_hulls", false);
  robot.decomposition = read_decomposition(node, "convex_hulls");
  return robot;
}

/// Pairs that an SRDF file keeps from touching become filters; those of links that the robot has not are passed over.
void add_srdf(const YamlNode& node, const RobotSpec& robot, std::span<const std::string> links, Scene& scene) {
  const auto file = find_resource(node.string(), node.file().parent_path(), robot.package_dirs);
  if (file.empty()) node.fail(fmt::format("'{}', which does not exist", node.string()), "an SRDF file");
  const auto known = [&](const std::string& link) { return std::find(links.begin(), links.end(), link) != links.end(); };
  for (const auto& [a, b] : read_srdf(file)) {
    if (known(a) && known(b))
      scene.filters.push_back({fmt::format("{}/{}", robot.name, a), fmt::format("{}/{}", robot.name, b), std::nullopt});
  }
}

/// Adds a robot, with what else its file brings, to the scene.
void add_robot(const YamlNode& node, std::span<const std::filesystem::path> package_dirs, Scene& scene, std::vector<std::string>& names) {
  RobotSpec robot = read_robot(node, package_dirs);
  const RobotTree tree = read_robot_tree(robot);
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
  if (const auto srdf = node.find("srdf")) add_srdf(*srdf, robot, links, scene);
  if (robot.mjcf.empty())
    scene.robots.push_back(std::move(robot));
  else
    add_mjcf(scene, robot);
}

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

Pose read_pose(const YamlNode& node) {
  node.require_map({"position", "quaternion_wxyz", "rpy"});
  Pose pose;
  if (const auto position = node.find("position")) pose.p = position->vector3();
  pose.R = read_rotation(node);
  return pose;
}

FixedSpec read_fixed(const YamlNode& node) {
  node.require_map({"name", "pose", "friction", "shapes"});
  FixedSpec fixed;
  fixed.name = read_name(node);
  if (const auto pose = node.find("pose")) fixed.X_WB = read_pose(*pose);
  fixed.geometries = read_geometries(node, node.nonnegative_or("friction", 1.0), true);
  return fixed;
}

Scene read_scene(const YamlNode& node, std::span<const std::filesystem::path> package_dirs) {
  node.require_map({"name", "gravity", "contact_distance", "max_contacts", "robots", "objects", "fixed", "filters"});
  Scene scene;
  scene.file = node.file();
  scene.name = node.string_or("name", node.file().has_filename() ? node.file().stem().string() : "scene");
  if (const auto gravity = node.find("gravity")) scene.gravity = gravity->vector3();
  scene.contact_distance = node.positive_or("contact_distance", scene.contact_distance);
  if (const auto most = node.find("max_contacts")) scene.max_contacts = most->positive_int();

  std::vector<std::string> owners, names;
  const auto items = [&](std::string_view key) {
    const auto list = node.find(key);
    return list ? list->items() : std::vector<YamlNode>{};
  };
  const auto add_owner = [&](const YamlNode& item, const std::string& name) {
    if (std::find(owners.begin(), owners.end(), name) != owners.end())
      item.at("name").fail(fmt::format("'{}' twice", name), "each name once");
    owners.push_back(name);
    names.push_back(name);
  };
  const auto add_geometries = [&](const std::string& owner, const std::vector<GeometrySpec>& geometries) {
    for (const auto& geometry : geometries) names.push_back(fmt::format("{}/{}", owner, geometry.name));
  };
  for (const YamlNode& item : items("objects")) {
    ObjectSpec object = read_object(item);
    if (!object.parent.empty() && std::find(owners.begin(), owners.end(), object.parent) == owners.end())
      item.at("parent").fail_unknown("object listed before", object.parent, owners);
    scene.objects.push_back(std::move(object));
    add_owner(item, scene.objects.back().name);
    add_geometries(scene.objects.back().name, scene.objects.back().geometries);
  }
  for (const YamlNode& item : items("robots")) {
    const std::size_t objects = scene.objects.size(), fixed = scene.fixed.size();
    add_robot(item, package_dirs, scene, names);
    add_owner(item, scene.robots.back().name);
    for (std::size_t i = objects; i < scene.objects.size(); ++i) {  // those that an MJCF brings
      add_owner(item, scene.objects[i].name);
      add_geometries(scene.objects[i].name, scene.objects[i].geometries);
    }
    for (std::size_t i = fixed; i < scene.fixed.size(); ++i) {
      add_owner(item, scene.fixed[i].name);
      add_geometries(scene.fixed[i].name, scene.fixed[i].geometries);
    }
  }
  for (const YamlNode& item : items("fixed")) {
    scene.fixed.push_back(read_fixed(item));
    add_owner(item, scene.fixed.back().name);
    add_geometries(scene.fixed.back().name, scene.fixed.back().geometries);
  }
  for (const YamlNode& item : items("filters")) scene.filters.push_back(read_filter(item, names));
  return scene;
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
