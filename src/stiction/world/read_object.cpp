#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stiction/core/faults.hpp"
#include "stiction/world/ellipsoid.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/scene_sections.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/urdf.hpp"

namespace stiction::world {
namespace {

constexpr double kQuaternionTolerance = 1e-3;  ///< files round quaternions; the reader normalises

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

/// Reads the convex parts of a mesh file; a non-convex mesh has several.
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

/// Reads one shape, or the convex parts of a mesh.
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
  if (kind == "ellipsoid") {
    node.require_map({"radii"});
    const Eigen::Vector3d radii = node.at("radii").vector3();
    if (!(radii.minCoeff() > 0)) node.at("radii").fail(fmt::format("{}, {}, {}", radii[0], radii[1], radii[2]), "three numbers > 0");
    return {Mesh{std::make_shared<const ConvexMesh>(make_ellipsoid(radii))}};
  }
  if (kind == "half_space") {
    if (!half_space_allowed) node.fail("a half-space", "a shape with a finite volume (half-spaces are for fixed bodies)");
    if (node.kind() != YamlNode::Kind::Null) node.require_map({});
    return {HalfSpace{}};
  }
  return read_mesh(node);
}

/// Surface properties that an entry of `objects` or `fixed` states for all its shapes.
struct Surface {
  explicit Surface(const YamlNode& owner)
      : friction(owner.nonnegative_or("friction", 1.0)),
        max_force(owner.positive_or("max_force", GeometrySpec{}.max_force)),
        rule(read_surface_rule(owner, {})) {}
  double friction, max_force;
  SurfaceRule rule;
};

/// Adds the geometries of an entry of `shapes`. @param number  number of the entry, which names it if it has no name
void add_geometries(const YamlNode& item, const Surface& surface, bool half_space_allowed, int number, std::vector<GeometrySpec>& out) {
  static constexpr std::string_view kKinds[] = {"sphere", "box", "capsule", "cylinder", "ellipsoid", "mesh", "half_space"};
  item.require_map({"name", "pose", "friction", "torsional_friction", "rolling_friction", "max_force", "sphere", "box", "capsule",
                    "cylinder", "ellipsoid", "mesh", "half_space"});
  std::vector<Shape> shapes;
  int found = 0;
  for (const std::string_view kind : kKinds) {
    if (!item.has(kind)) continue;
    ++found;
    shapes = read_shape(item.at(kind), kind, half_space_allowed);
  }
  if (found != 1) item.fail(fmt::format("{} shapes", found), "exactly one of sphere, box, capsule, cylinder, ellipsoid, mesh, half_space");
  const std::string name = item.string_or("name", fmt::format("{}_{}", shape_name(shapes[0]), number));
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    GeometrySpec geometry{.name = part_name(name, k, shapes.size()), .shape = shapes[k], .X_BG = {}};
    for (const auto& other : out) {
      if (other.name == geometry.name) item.fail(fmt::format("the name '{}' twice", geometry.name), "each name once");
    }
    if (const auto pose = item.find("pose")) geometry.X_BG = read_pose(*pose);
    geometry.friction = item.nonnegative_or("friction", surface.friction);
    geometry.max_force = item.positive_or("max_force", surface.max_force);
    geometry.rule = read_surface_rule(item, surface.rule);
    out.push_back(std::move(geometry));
  }
}

std::vector<GeometrySpec> read_geometries(const YamlNode& node, bool half_space_allowed) {
  const Surface surface(node);
  std::vector<GeometrySpec> out;
  core::Faults faults;
  int number = 0;
  for (const YamlNode& item : node.at("shapes").items())
    faults.collect([&] { add_geometries(item, surface, half_space_allowed, number++, out); });
  faults.raise();
  if (out.empty()) node.at("shapes").fail("at least one shape");
  return out;
}

Eigen::Vector3d read_axis(const YamlNode& node) {
  const Eigen::Vector3d axis = node.vector3();
  if (!(axis.norm() > 1e-6)) node.fail("0, 0, 0", "an axis other than 0");
  return axis.normalized();
}

/// Reads the joint of the object and the properties of that joint.
void read_motion(const YamlNode& node, ObjectSpec& object) {
  static constexpr std::string_view kJoints[] = {"free", "planar_xy", "planar_yz", "planar_xz", "hinge", "slider"};
  const std::string joint = node.at("joint").one_of(kJoints);
  object.joint = static_cast<ObjectJoint>(std::find(std::begin(kJoints), std::end(kJoints), joint) - std::begin(kJoints));
  object.parent = node.string_or("parent", "");
  const bool single = object.joint == ObjectJoint::Hinge || object.joint == ObjectJoint::Slider;
  if (single) object.axis = read_axis(node.at("axis"));
  for (const std::string_view key : {"axis", "limits", "parent", "joint_friction", "joint_stiffness", "joint_rest"}) {
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
  object.joint_friction = node.nonnegative_or("joint_friction", 0);
  object.joint_damping = node.nonnegative_or("joint_damping", 0);
  object.joint_stiffness = node.nonnegative_or("joint_stiffness", 0);
  object.joint_rest = node.number_or("joint_rest", 0);
  if (node.has("joint_rest") && object.joint_stiffness == 0)
    node.at("joint_rest").fail("joint_rest without joint_stiffness", "both: the spring, and where it is at rest");
}

void read_mass(const YamlNode& node, ObjectSpec& object) {
  object.mass = node.at("mass").positive();
  if (!object.geometries.empty()) {
    const VolumeProperties shape = calc_volume_properties(object.geometries);
    constexpr double kLeast = 1e-150;  // of a cube of 1e-50 m; moments of less vanish
    if (!(shape.volume >= kLeast)) node.at("shapes").fail(fmt::format("a volume of {:.3g} m³", shape.volume), "sizes in metres");
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
  round_center(object);
}

}  // namespace

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

SurfaceRule read_surface_rule(const YamlNode& node, SurfaceRule rule) {
  rule.torsional = node.nonnegative_or("torsional_friction", rule.torsional);
  rule.rolling = node.nonnegative_or("rolling_friction", rule.rolling);
  rule.dimension = rule.rolling > 0 ? 6 : rule.torsional > 0 ? 4 : 3;
  return rule;
}

Pose read_pose(const YamlNode& node) {
  node.require_map({"position", "quaternion_wxyz", "rpy"});
  Pose pose;
  if (const auto position = node.find("position")) pose.p = position->vector3();
  pose.R = read_rotation(node);
  return pose;
}

FixedSpec read_fixed(const YamlNode& node) {
  node.require_map({"name", "pose", "friction", "torsional_friction", "rolling_friction", "max_force", "shapes"});
  FixedSpec fixed;
  fixed.name = read_name(node);
  if (const auto pose = node.find("pose")) fixed.X_WB = read_pose(*pose);
  fixed.geometries = read_geometries(node, true);
  return fixed;
}

void round_center(ObjectSpec& object) {
  constexpr double kRounding = 1e-6;  // rounding error, as a share of the radius of gyration
  if (object.p_BCom.norm() < kRounding * std::sqrt(object.inertia.trace() / object.mass)) object.p_BCom.setZero();
}

ObjectSpec read_object(const YamlNode& node) {
  node.require_map();
  core::Faults faults;
  faults.collect([&] {
    node.require_map({"name", "parent", "joint", "axis", "pose", "mass", "inertia", "center_of_mass", "friction", "torsional_friction",
                      "rolling_friction", "max_force", "limits", "joint_friction", "joint_damping", "joint_stiffness", "joint_rest",
                      "shapes"});
  });
  ObjectSpec object;
  faults.collect([&] { object.name = read_name(node); });
  faults.collect([&] { read_motion(node, object); });
  faults.collect([&] {
    if (node.has("shapes") || !node.has("inertia")) object.geometries = read_geometries(node, false);
  });
  faults.collect([&] { read_mass(node, object); });
  faults.raise();
  return object;
}

}  // namespace stiction::world
