#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>

#include "stiction/world/model_parts.hpp"

namespace stiction::world {

using Eigen::Matrix3d;

namespace {

/// The object that this one hangs on, −1 for the world.
int find_parent(const Model::Impl& m, const ObjectSpec& spec, int index) {
  if (spec.parent.empty()) return -1;
  if (spec.joint != ObjectJoint::Hinge && spec.joint != ObjectJoint::Slider)
    core::throw_invalid("parent", fmt::format("'{}'", spec.parent), "it only for hinge and slider objects");
  for (int i = 0; i < index; ++i) {
    if (m.objects[at(i)].name == spec.parent) return i;
  }
  core::throw_invalid("parent", fmt::format("'{}'", spec.parent), "an object listed before");
}

void require_no_joint_friction(const ObjectSpec& spec) {
  for (const auto& [field, value] : {std::pair{"joint_friction", spec.joint_friction}, {"joint_damping", spec.joint_damping}}) {
    if (value != 0) core::throw_invalid(field, fmt::format("{:g}", value), "it only for hinge and slider objects");
  }
}

}  // namespace

void add_object(ModelParts& parts, const ObjectSpec& spec, int index) {
  Model::Impl& m = parts.m;
  parts.add_owner_name(spec.name);
  core::require_positive("mass", spec.mass);
  core::require_nonnegative("weight_share", spec.weight_share);
  core::require_nonnegative("joint_friction", spec.joint_friction);
  core::require_nonnegative("joint_damping", spec.joint_damping);
  core::require_finite("p_BCom", std::span(spec.p_BCom.data(), 3));
  if (!is_rotation(spec.X_WP.R) || !spec.X_WP.p.allFinite()) core::throw_invalid("pose", "no rigid transform", "one");
  const Eigen::LLT<Matrix3d> factor(spec.inertia);
  if (!spec.inertia.allFinite() || factor.info() != Eigen::Success || !spec.inertia.isApprox(spec.inertia.transpose())) {
    core::throw_invalid("inertia", "a matrix that is not symmetric positive definite", "one that is");
  }

  ObjectNode node{.joint = spec.joint,
                  .q = m.n_q,
                  .v = m.n_v,
                  .parent = find_parent(m, spec, index),
                  .X_WP = spec.X_WP,
                  .mass = spec.mass,
                  .weight_share = spec.weight_share,
                  .p_BCom = spec.p_BCom,
                  .inertia = spec.inertia};
  const auto dof = [&](std::string_view name, DofKind kind, double lower = -kInfinity, double upper = kInfinity) {
    parts.add_dof(fmt::format("{}/{}", spec.name, name), kind, BodyKind::Object, index, lower, upper, 0);
  };
  const auto planar = [&](int first, int second) {
    static constexpr std::string_view kAxes[] = {"x", "y", "z"};
    node.first = first, node.second = second, node.normal = 3 - first - second;
    node.n_v = 3;
    dof(kAxes[first], DofKind::Prismatic);
    dof(kAxes[second], DofKind::Prismatic);
    dof("theta", DofKind::Revolute);
  };
  if (spec.joint != ObjectJoint::Hinge && spec.joint != ObjectJoint::Slider) require_no_joint_friction(spec);
  switch (spec.joint) {
    case ObjectJoint::Free:
      node.n_v = 6;
      for (const auto name : {"x", "y", "z"}) dof(name, DofKind::Prismatic);
      for (const auto name : {"rx", "ry", "rz"}) dof(name, DofKind::Revolute);
      break;
    case ObjectJoint::PlanarXY:
      planar(0, 1);
      break;
    case ObjectJoint::PlanarYZ:
      planar(1, 2);
      break;
    case ObjectJoint::PlanarXZ:
      planar(0, 2);
      break;
    case ObjectJoint::Hinge:
    case ObjectJoint::Slider: {
      if (!(spec.axis.norm() > 1e-9) || !spec.axis.allFinite()) core::throw_invalid("axis", "0 or not finite", "a direction");
      node.axis_P = spec.axis.normalized();
      node.n_v = 1;
      const auto limits = spec.limits.value_or(std::array{-kInfinity, kInfinity});
      if (!(limits[0] <= limits[1])) core::throw_invalid("limits", fmt::format("[{}, {}]", limits[0], limits[1]), "lower ≤ upper");
      const bool hinge = spec.joint == ObjectJoint::Hinge;
      dof(hinge ? "angle" : "position", hinge ? DofKind::Revolute : DofKind::Prismatic, limits[0], limits[1]);
      parts.set_joint_friction(spec.joint_friction, spec.joint_damping);
      break;
    }
  }
  const int n_q = spec.joint == ObjectJoint::Free ? 7 : node.n_v;
  std::vector<int> dofs;
  if (node.parent >= 0) dofs = m.bodies[at(m.object_nodes[at(node.parent)].body)].dofs;
  for (int i = 0; i < node.n_v; ++i) dofs.push_back(m.n_v + i);
  node.body = parts.add_body(spec.name, BodyKind::Object, index, std::move(dofs));
  m.inertias.back() = {spec.mass, spec.p_BCom, spec.inertia};
  for (const auto& geometry : spec.geometries)
    parts.add_geometry(node.body, geometry.name, geometry.shape, geometry.X_BG, geometry.friction, geometry.mask, geometry.max_force);
  if (node.parent >= 0) parts.adjacent.insert({parts.group[at(m.object_nodes[at(node.parent)].body)], parts.group[at(node.body)]});
  m.objects.push_back({.name = spec.name,
                       .body = node.body,
                       .v_begin = m.n_v,
                       .n_v = node.n_v,
                       .q_begin = m.n_q,
                       .n_q = n_q,
                       .mass = spec.mass,
                       .parent = node.parent});
  m.object_nodes.push_back(node);
  for (int o = index; o >= 0; o = m.objects[at(o)].parent) {
    m.objects[at(o)].carried_mass += spec.mass;
    m.object_nodes[at(o)].carried.push_back(index);
  }
  m.n_v += node.n_v;
  m.n_q += n_q;
}

}  // namespace stiction::world
