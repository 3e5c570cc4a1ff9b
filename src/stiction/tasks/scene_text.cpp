#include "stiction/tasks/scene_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "stiction/core/sha256.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::tasks {
namespace {

using world::Pose;

std::string number(double value) { return fmt::format("{:.12g}", value + 0.0); }
/// For coordinates and rotations, where 1e-17 and 0 are the same.
std::string coordinate(double value) { return number(std::round(value * 1e12) / 1e12 + 0.0); }

template <class Range>
std::string list(const Range& values) {
  std::string out = "[";
  for (const double value : values) out += (out.size() > 1 ? ", " : "") + coordinate(value);
  return out + "]";
}

std::string pose(const Pose& X) {
  const Eigen::Matrix3d Rt = X.R.transpose();  // its columns in memory order are the rows of R
  return fmt::format("{{p: {}, R: {}}}", list(X.p), list(Rt.reshaped()));
}

std::string_view joint_name(world::ObjectJoint joint) {
  switch (joint) {
    case world::ObjectJoint::Free:
      return "free";
    case world::ObjectJoint::PlanarXY:
      return "planar_xy";
    case world::ObjectJoint::PlanarYZ:
      return "planar_yz";
    case world::ObjectJoint::PlanarXZ:
      return "planar_xz";
    case world::ObjectJoint::Hinge:
      return "hinge";
    case world::ObjectJoint::Slider:
      return "slider";
  }
  return "";
}

/// Of a robot joint they stand in its file, whose digest is there.
/// Only where commands may go beyond the limits, so that the text of other scenes stays as it was.
std::string commands(const world::Dof& dof) {
  if (dof.command_lower == dof.lower && dof.command_upper == dof.upper) return "";
  return fmt::format(", commands: [{}, {}]", number(dof.command_lower), number(dof.command_upper));
}

std::string joint_friction(const world::Dof& dof) {
  if (dof.owner_kind != world::BodyKind::Object) return "";
  std::string out;
  if (dof.friction != 0 || dof.damping != 0) out += fmt::format(", friction: {}, damping: {}", number(dof.friction), number(dof.damping));
  if (dof.spring != 0) out += fmt::format(", spring: {}, rest: {}", number(dof.spring), number(dof.spring_rest));
  return out;
}

struct ShapeText {
  std::string operator()(const world::Sphere& s) const { return fmt::format("{{sphere: {}}}", number(s.radius)); }
  std::string operator()(const world::Capsule& s) const {
    return fmt::format("{{capsule: [{}, {}]}}", number(s.radius), number(s.half_length));
  }
  std::string operator()(const world::Box& s) const { return fmt::format("{{box: {}}}", list(s.half_extents)); }
  std::string operator()(const world::Cylinder& s) const {
    return fmt::format("{{cylinder: [{}, {}]}}", number(s.radius), number(s.half_length));
  }
  std::string operator()(const world::HalfSpace&) const { return "{half_space: true}"; }
  std::string operator()(const world::Mesh& s) const {
    std::string numbers = list(s.mesh->vertices.reshaped());
    for (const int index : s.mesh->triangles.reshaped()) numbers += fmt::format(" {}", index);
    return fmt::format("{{mesh: {}}}", core::sha256(numbers));
  }
};

/// Of surfaces that do more or less than resist sliding.
std::string moments(const world::SurfaceRule& rule) {
  if (rule.dimension == 3) return "";
  return fmt::format("dimension: {}, torsional: {}, rolling: {}, ", rule.dimension, number(rule.torsional), number(rule.rolling));
}

}  // namespace

std::string make_scene_text(const world::Model& model) {
  const world::Scene& scene = model.scene();
  std::string out = fmt::format("gravity: {}\ncontact_distance: {}\nmax_contacts: {}\n", list(scene.gravity),
                                number(scene.contact_distance), scene.max_contacts ? std::to_string(*scene.max_contacts) : "~");
  out += "robots:\n";
  for (const auto& robot : scene.robots) {
    const char* kind = robot.mjcf.empty() ? "urdf" : "mjcf";
    const std::string file = robot.text.empty() ? robot.file().filename().string() : world::kTextName;
    out += fmt::format("- {{name: {}, {}: {}, {}_sha256: {}, base: {}}}\n", robot.name, kind, file, kind, robot.contents->sha256,
                       pose(robot.X_WBase));
  }
  out += "objects:\n";
  for (const auto& object : scene.objects) {
    const std::string parent = object.parent.empty() ? "" : fmt::format(" parent: {},", object.parent);
    out += fmt::format("- {{name: {},{} joint: {}, axis: {}, placed: {}, mass: {}, com: {}, inertia: {}, limits: {}}}\n", object.name,
                       parent, joint_name(object.joint), list(object.axis), pose(object.X_WP), number(object.mass), list(object.p_BCom),
                       list(object.inertia.reshaped()), object.limits ? list(*object.limits) : "~");
  }
  out += "fixed:\n";
  for (const auto& fixed : scene.fixed) out += fmt::format("- {{name: {}, pose: {}}}\n", fixed.name, pose(fixed.X_WB));
  out += "filters:\n";
  for (const auto& filter : scene.filters) {
    out += fmt::format("- {{a: \"{}\", b: \"{}\", max_distance: {}}}\n", filter.a, filter.b,
                       filter.max_distance ? number(*filter.max_distance) : "~");
  }
  out += "coordinates:\n";
  for (const auto& dof : model.dofs()) {
    out += fmt::format("- {{name: {}, lower: {}, upper: {}, stiffness: {}{}{}{}}}\n", dof.name, number(dof.lower), number(dof.upper),
                       number(dof.stiffness), commands(dof),
                       std::isfinite(dof.effort) ? fmt::format(", effort: {}", number(dof.effort)) : "", joint_friction(dof));
  }
  out += "geometries:\n";
  for (const auto& geometry : model.geometries()) {
    out += fmt::format("- {{name: {}, shape: {}, pose: {}, {}friction: {}{}}}\n", geometry.name, std::visit(ShapeText{}, geometry.shape),
                       pose(geometry.X_BG), moments(geometry.rule), number(geometry.friction),
                       std::isfinite(geometry.max_force) ? fmt::format(", max_force: {}", number(geometry.max_force)) : "");
  }
  return out;
}

}  // namespace stiction::tasks
