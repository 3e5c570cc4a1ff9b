#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>

#include "stiction/world/model_parts.hpp"

namespace stiction::world {

using Eigen::Matrix3d;

namespace {

/// Index of the object that this one hangs on; −1 for the world.
int find_parent(const Model::Impl& m, const ObjectSpec& spec, int index) {
  if (spec.parent.empty()) return -1;
  if (spec.joint != ObjectJoint::Hinge && spec.joint != ObjectJoint::Slider)
    core::throw_invalid("parent", fmt::format("'{}'", spec.parent), "it only for hinge and slider objects");
  for (int i = 0; i < index; ++i) {
    if (m.objects[at(i)].name == spec.parent) return i;
  }
  core::throw_invalid("parent", fmt::format("'{}'", spec.parent), "an object listed before");
}

/// Checks the numbers and frames of an object. @throws core::InvalidInput: a value that no object can have
void require_object(const ObjectSpec& spec) {
  core::require_positive("mass", spec.mass);
  core::require_nonnegative("weight_share", spec.weight_share);
  core::require_nonnegative("joint_friction", spec.joint_friction);
  core::require_nonnegative("joint_damping", spec.joint_damping);
  core::require_nonnegative("joint_stiffness", spec.joint_stiffness);
  core::require_finite("joint_rest", std::span(&spec.joint_rest, 1));
  core::require_finite("p_BCom", std::span(spec.p_BCom.data(), 3));
  if (!is_rotation(spec.X_WP.R) || !spec.X_WP.p.allFinite()) core::throw_invalid("pose", "no rigid transform", "one");
  const Eigen::LLT<Matrix3d> factor(spec.inertia);
  if (!spec.inertia.allFinite() || factor.info() != Eigen::Success || !spec.inertia.isApprox(spec.inertia.transpose())) {
    core::throw_invalid("inertia", "a matrix that is not symmetric positive definite", "one that is");
  }
  if (spec.joint == ObjectJoint::Hinge || spec.joint == ObjectJoint::Slider) return;
  for (const auto& [field, value] : {std::pair{"joint_friction", spec.joint_friction}, {"joint_stiffness", spec.joint_stiffness}}) {
    if (value != 0) core::throw_invalid(field, fmt::format("{:g}", value), "it only for hinge and slider objects");
  }
}

/// Adds the coordinates of one object to a model.
class CoordinateAdder {
 public:
  CoordinateAdder(ModelParts& parts, const ObjectSpec& spec, int index, ObjectNode& node)
      : parts_(parts), spec_(spec), index_(index), node_(node) {}

  void add() {
    switch (spec_.joint) {
      case ObjectJoint::Free:
        node_.n_v = 6;
        for (const auto name : {"x", "y", "z"}) add_dof(name, DofKind::Prismatic);
        for (const auto name : {"rx", "ry", "rz"}) add_dof(name, DofKind::Revolute);
        return;
      case ObjectJoint::PlanarXY:
        return add_planar(0, 1);
      case ObjectJoint::PlanarYZ:
        return add_planar(1, 2);
      case ObjectJoint::PlanarXZ:
        return add_planar(0, 2);
      case ObjectJoint::Hinge:
        return add_axis("angle", DofKind::Revolute);
      case ObjectJoint::Slider:
        return add_axis("position", DofKind::Prismatic);
    }
  }

 private:
  void add_dof(std::string_view name, DofKind kind, double lower = -kInfinity, double upper = kInfinity) {
    parts_.add_dof(fmt::format("{}/{}", spec_.name, name), kind, BodyKind::Object, index_, lower, upper, 0);
    parts_.set_joint_friction(spec_.joint_friction, spec_.joint_damping);
  }

  void add_planar(int first, int second) {
    static constexpr std::string_view kAxes[] = {"x", "y", "z"};
    node_.first = first, node_.second = second, node_.normal = 3 - first - second;
    node_.n_v = 3;
    add_dof(kAxes[first], DofKind::Prismatic);
    add_dof(kAxes[second], DofKind::Prismatic);
    add_dof("theta", DofKind::Revolute);
  }

  /// Adds the coordinate of a hinge or a slider.
  void add_axis(std::string_view name, DofKind kind) {
    if (!(spec_.axis.norm() > 1e-9) || !spec_.axis.allFinite()) core::throw_invalid("axis", "0 or not finite", "a direction");
    node_.axis_P = spec_.axis.normalized();
    node_.n_v = 1;
    const auto limits = spec_.limits.value_or(std::array{-kInfinity, kInfinity});
    if (!(limits[0] <= limits[1])) core::throw_invalid("limits", fmt::format("[{}, {}]", limits[0], limits[1]), "lower ≤ upper");
    add_dof(name, kind, limits[0], limits[1]);
    parts_.set_joint_spring(spec_.joint_stiffness, spec_.joint_rest);
  }

  ModelParts& parts_;
  const ObjectSpec& spec_;
  int index_;
  ObjectNode& node_;
};

}  // namespace

void add_object(ModelParts& parts, const ObjectSpec& spec, int index) {
  Model::Impl& m = parts.m;
  parts.add_owner_name(spec.name);
  require_object(spec);
  ObjectNode node{.joint = spec.joint,
                  .q = m.n_q,
                  .v = m.n_v,
                  .parent = find_parent(m, spec, index),
                  .X_WP = spec.X_WP,
                  .mass = spec.mass,
                  .weight_share = spec.weight_share,
                  .p_BCom = spec.p_BCom,
                  .inertia = spec.inertia};
  CoordinateAdder(parts, spec, index, node).add();
  const int n_q = spec.joint == ObjectJoint::Free ? 7 : node.n_v;
  std::vector<int> dofs;
  if (node.parent >= 0) dofs = m.bodies[at(m.object_nodes[at(node.parent)].body)].dofs;
  for (int i = 0; i < node.n_v; ++i) dofs.push_back(m.n_v + i);
  node.body = parts.add_body(spec.name, BodyKind::Object, index, std::move(dofs));
  m.inertias.back() = {spec.mass, spec.p_BCom, spec.inertia};
  for (const auto& geometry : spec.geometries) parts.add_geometry(node.body, geometry);
  if (node.parent >= 0) parts.join(m.object_nodes[at(node.parent)].body, node.body, m.scene.objects[at(node.parent)].geometries.empty());
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
