#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/model.hpp"
#include "stiction/world/model_impl.hpp"

namespace stiction::world {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

Quaterniond read_quaternion(const VectorRef& q, int at) { return {q[at + 6], q[at + 3], q[at + 4], q[at + 5]}; }

/// Unit quaternion of a rotation vector (exponential map).
Quaterniond exp_so3(const Vector3d& r) {
  const double angle2 = r.squaredNorm();
  if (angle2 < 1e-8) {  // next terms of the series are below 1e-17
    const double scale = 0.5 - angle2 / 48;
    return {1 - angle2 / 8, scale * r[0], scale * r[1], scale * r[2]};
  }
  const double angle = std::sqrt(angle2);
  const double scale = std::sin(angle / 2) / angle;
  return {std::cos(angle / 2), scale * r[0], scale * r[1], scale * r[2]};
}

/// Rotation vector of a unit quaternion, length ≤ π: q and −q give the same one.
Vector3d log_so3(Quaterniond q) {
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double n = q.vec().norm();
  if (n < 1e-8) return 2 / q.w() * q.vec();
  return 2 * std::atan2(n, q.w()) / n * q.vec();
}

/// Rotation about coordinate axis k.
Matrix3d rotation_about(int k, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  Matrix3d R = Matrix3d::Zero();
  R(k, k) = 1;
  R(i, i) = c, R(i, j) = -s;
  R(j, i) = s, R(j, j) = c;
  return R;
}

/// Placed frame X_WP of an object, given the pose of its parent.
Pose placed(const ObjectNode& node, const Pose* X_WParent) { return X_WParent ? *X_WParent * node.X_WP : node.X_WP; }

Pose calc_object_pose(const ObjectNode& node, const Pose& X_WP, const VectorRef& q) {
  switch (node.joint) {
    case ObjectJoint::Free:
      return {read_quaternion(q, node.q).toRotationMatrix(), q.segment<3>(node.q)};
    case ObjectJoint::PlanarXY:
    case ObjectJoint::PlanarYZ:
    case ObjectJoint::PlanarXZ:
      return {X_WP.R * rotation_about(node.normal, q[node.q + 2]),
              X_WP.p + q[node.q] * X_WP.R.col(node.first) + q[node.q + 1] * X_WP.R.col(node.second)};
    case ObjectJoint::Hinge:
      return {X_WP.R * Eigen::AngleAxisd(q[node.q], node.axis_P).toRotationMatrix(), X_WP.p};
    case ObjectJoint::Slider:
      return {X_WP.R, X_WP.p + q[node.q] * (X_WP.R * node.axis_P)};
  }
  return {};
}

void calc_object_axes(const ObjectNode& node, const Pose& X_WP, const Pose& X_WB, Kinematics& out) {
  out.origin_W.middleCols(node.v, node.n_v).colwise() = X_WB.p;
  switch (node.joint) {
    case ObjectJoint::Free:
      out.axis_W.middleCols<3>(node.v).setIdentity();
      out.axis_W.middleCols<3>(node.v + 3) = X_WB.R;
      break;
    case ObjectJoint::PlanarXY:
    case ObjectJoint::PlanarYZ:
    case ObjectJoint::PlanarXZ:
      out.axis_W.col(node.v) = X_WP.R.col(node.first);
      out.axis_W.col(node.v + 1) = X_WP.R.col(node.second);
      out.axis_W.col(node.v + 2) = X_WP.R.col(node.normal);
      break;
    case ObjectJoint::Hinge:
    case ObjectJoint::Slider:
      out.axis_W.col(node.v) = X_WP.R * node.axis_P;
      break;
  }
}

}  // namespace

struct KinematicsWorkspace::Impl {};

KinematicsWorkspace::KinematicsWorkspace(const Model&) : impl_(std::make_unique<Impl>()) {}
KinematicsWorkspace::~KinematicsWorkspace() = default;
KinematicsWorkspace::KinematicsWorkspace(KinematicsWorkspace&&) noexcept = default;

void calc_kinematics(const Model& model, VectorRef q, KinematicsWorkspace&, Kinematics& out) { calc_kinematics(model.impl(), q, out); }

void place_link(const LinkNode& node, const VectorRef& q, Kinematics& out) {
  const Pose& X_WP = out.X_WB[static_cast<std::size_t>(node.parent)];
  Pose& X_WB = out.X_WB[static_cast<std::size_t>(node.body)];
  const Vector3d p = X_WP.R * node.p_PJ + X_WP.p;
  const auto joint_value = [&] { return node.axis == node.v ? q[node.q] : node.ratio * q[node.q] + node.offset; };
  switch (node.kind) {
    case LinkNode::Kind::Revolute: {
      const double value = joint_value();
      const Matrix3d R_PB = node.C0 + std::cos(value) * node.C1 + std::sin(value) * node.C2;
      X_WB.R.noalias() = X_WP.R * R_PB;
      X_WB.p = p;
      out.axis_W.col(node.axis).noalias() = X_WP.R * node.axis_P;
      out.origin_W.col(node.axis) = p;
      break;
    }
    case LinkNode::Kind::Prismatic: {
      const Vector3d axis = X_WP.R * node.axis_P;
      X_WB.R.noalias() = X_WP.R * node.C0;
      X_WB.p = p + joint_value() * axis;
      out.axis_W.col(node.axis) = axis;
      out.origin_W.col(node.axis) = X_WB.p;
      break;
    }
    case LinkNode::Kind::Welded:
      X_WB.R.noalias() = X_WP.R * node.C0;
      X_WB.p = p;
      break;
  }
}

void calc_kinematics(const Model::Impl& m, const VectorRef& q, Kinematics& out) {
  core::require_size("q", q.size(), m.n_q);
  const Eigen::Index n_axes = m.n_v + static_cast<Eigen::Index>(m.followers.size());
  if (out.X_WB.size() != m.bodies.size() || out.axis_W.cols() != n_axes) {
    out.X_WB.resize(m.bodies.size());
    out.axis_W.resize(3, n_axes);
    out.origin_W.resize(3, n_axes);
  }
  for (const auto& [body, pose] : m.constant_poses) out.X_WB[static_cast<std::size_t>(body)] = pose;
  for (const ObjectNode& node : m.object_nodes) {
    Pose& X_WB = out.X_WB[static_cast<std::size_t>(node.body)];
    const bool hangs = node.parent >= 0;
    const int parent = hangs ? m.object_nodes[static_cast<std::size_t>(node.parent)].body : 0;
    const Pose X_WP = placed(node, hangs ? &out.X_WB[static_cast<std::size_t>(parent)] : nullptr);
    X_WB = calc_object_pose(node, X_WP, q);
    calc_object_axes(node, X_WP, X_WB, out);
  }
  for (const LinkNode& node : m.link_nodes) place_link(node, q, out);
}

void retract(const Model& model, VectorRef q, VectorRef delta, Eigen::Ref<Eigen::VectorXd> out) {
  const Model::Impl& m = model.impl();
  core::require_size("q", q.size(), m.n_q);
  core::require_size("delta", delta.size(), m.n_v);
  core::require_size("out", out.size(), m.n_q);
  for (const ObjectNode& node : m.object_nodes) {
    if (node.joint != ObjectJoint::Free) {
      out.segment(node.q, node.n_v) = q.segment(node.q, node.n_v) + delta.segment(node.v, node.n_v);
      continue;
    }
    const Quaterniond next = (read_quaternion(q, node.q) * exp_so3(delta.segment<3>(node.v + 3))).normalized();
    out.segment<3>(node.q) = q.segment<3>(node.q) + delta.segment<3>(node.v);
    out.segment<4>(node.q + 3) = next.coeffs();  // x, y, z, w
  }
  out.tail(m.n_a) = q.tail(m.n_a) + delta.tail(m.n_a);
}

void local(const Model& model, VectorRef q0, VectorRef q1, Eigen::Ref<Eigen::VectorXd> out) {
  const Model::Impl& m = model.impl();
  core::require_size("q0", q0.size(), m.n_q);
  core::require_size("q1", q1.size(), m.n_q);
  core::require_size("out", out.size(), m.n_v);
  for (const ObjectNode& node : m.object_nodes) {
    if (node.joint != ObjectJoint::Free) {
      out.segment(node.v, node.n_v) = q1.segment(node.q, node.n_v) - q0.segment(node.q, node.n_v);
      continue;
    }
    out.segment<3>(node.v) = q1.segment<3>(node.q) - q0.segment<3>(node.q);
    out.segment<3>(node.v + 3) = log_so3(read_quaternion(q0, node.q).conjugate() * read_quaternion(q1, node.q));
  }
  out.tail(m.n_a) = q1.tail(m.n_a) - q0.tail(m.n_a);
}

Pose object_pose(const Model& model, VectorRef q, int object) {
  core::require_size("q", q.size(), model.n_q());
  const ObjectNode& node = model.impl().object_nodes.at(static_cast<std::size_t>(object));
  if (node.parent < 0) return calc_object_pose(node, node.X_WP, q);
  const Pose X_WParent = object_pose(model, q, node.parent);
  return calc_object_pose(node, placed(node, &X_WParent), q);
}

void require_configuration(const Model& model, std::string_view field, VectorRef q) {
  core::require_size(field, q.size(), model.n_q());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (!std::isfinite(q[i])) core::throw_invalid(fmt::format("{}[{}]", field, i), fmt::format("{}", q[i]), "a finite number");
  }
  for (const ObjectNode& node : model.impl().object_nodes) {
    if (node.joint != ObjectJoint::Free) continue;
    const double length = q.segment<4>(node.q + 3).norm();
    if (!(std::abs(length - 1) <= 1e-6)) {
      core::throw_invalid(fmt::format("{}[{}..{}]", field, node.q + 3, node.q + 6), fmt::format("a quaternion of length {:.9g}", length),
                          "length 1");
    }
  }
}

}  // namespace stiction::world
