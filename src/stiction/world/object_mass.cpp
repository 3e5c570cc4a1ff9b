#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "stiction/world/model_impl.hpp"
#include "stiction/world/object_derivatives.hpp"
#include "stiction/world/point_jacobian.hpp"

// Mass and gravity of objects with all objects that hang on them, and their derivatives; inertia of joints.

namespace stiction::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Computes the velocity of a body per coordinate of an object that moves it, for M_u and gravity: columns of the linear velocity of its centre of
/// mass and of its angular velocity.
void calc_columns(const Model::Impl& m, const Kinematics& kinematics, const ObjectNode& mover, const ObjectNode& moved,
                  Eigen::Matrix<double, 3, 6>& linear, Eigen::Matrix<double, 3, 6>& angular) {
  const Vector3d p_WCom = kinematics.X_WB[static_cast<std::size_t>(moved.body)] * moved.p_BCom;
  for (int i = 0; i < mover.n_v; ++i) {
    const Vector3d axis = kinematics.axis_W.col(mover.v + i);
    if (m.dofs[static_cast<std::size_t>(mover.v + i)].kind == DofKind::Prismatic) {
      linear.col(i) = axis;
      angular.col(i).setZero();
    } else {
      linear.col(i) = axis.cross(p_WCom - kinematics.origin_W.col(mover.v + i));
      angular.col(i) = axis;
    }
  }
}

bool carries(const ObjectNode& node, int object) {
  return std::find(node.carried.begin(), node.carried.end(), object) != node.carried.end();
}

/// Computes the derivatives of these columns by coordinate j of an object that moves `moved`, whose centre of mass is p_WCom.
void calc_column_rates(const Model::Impl& m, const Kinematics& kinematics, const ObjectNode& node, const ObjectNode& mover,
                       const Vector3d& p_WCom, int j, Eigen::Matrix<double, 3, 6>& d_linear, Eigen::Matrix<double, 3, 6>& d_angular) {
  const auto revolute = [&](int dof) { return m.dofs[static_cast<std::size_t>(dof)].kind == DofKind::Revolute; };
  const Vector3d axis_j = kinematics.axis_W.col(j), origin_j = kinematics.origin_W.col(j);
  const auto carry = [&](const Vector3d& p_W) { return revolute(j) ? Vector3d(axis_j.cross(p_W - origin_j)) : axis_j; };
  const bool same = &mover == &node;
  const bool moves_node = same || carries(mover, static_cast<int>(&node - m.object_nodes.data()));
  for (int i = 0; i < node.n_v; ++i) {
    const int dof = node.v + i;
    const Vector3d axis = kinematics.axis_W.col(dof), origin = kinematics.origin_W.col(dof);
    // A free object's own rotations turn only its rotation axes, since these are axes of the body.
    const bool turns = revolute(j) && moves_node && (!same || (node.joint == ObjectJoint::Free && revolute(dof)));
    const Vector3d d_axis = turns ? Vector3d(axis_j.cross(axis)) : Vector3d::Zero();
    if (!revolute(dof)) {
      d_linear.col(i) = d_axis;
      d_angular.col(i).setZero();
    } else {
      const Vector3d d_origin = moves_node ? carry(origin) : Vector3d::Zero();
      d_linear.col(i) = d_axis.cross(p_WCom - origin) + axis.cross(carry(p_WCom) - d_origin);
      d_angular.col(i) = d_axis;
    }
  }
}

}  // namespace

void calc_object_mass(const Model& model, const Kinematics& kinematics, int object, Eigen::Ref<Eigen::MatrixXd> M_u) {
  const Model::Impl& m = model.impl();
  const ObjectNode& node = m.object_nodes.at(static_cast<std::size_t>(object));
  core::require_size("M_u.rows", M_u.rows(), node.n_v);
  core::require_size("M_u.cols", M_u.cols(), node.n_v);
  M_u.setZero();
  Eigen::Matrix<double, 3, 6> linear, angular;
  for (const int o : node.carried) {
    const ObjectNode& moved = m.object_nodes[static_cast<std::size_t>(o)];
    calc_columns(m, kinematics, node, moved, linear, angular);
    const Matrix3d& R_WB = kinematics.X_WB[static_cast<std::size_t>(moved.body)].R;
    const Matrix3d inertia_W = R_WB * moved.inertia * R_WB.transpose();
    for (int i = 0; i < node.n_v; ++i) {
      const Vector3d momentum = moved.mass * linear.col(i);
      const Vector3d spin = inertia_W * angular.col(i);
      for (int j = 0; j < node.n_v; ++j) M_u(j, i) += linear.col(j).dot(momentum) + angular.col(j).dot(spin);
    }
  }
}

Eigen::VectorXd calc_joint_inertia(const Model& model, const Kinematics& kinematics) {
  const std::span<const JointMotor> motors = joint_motors(model);
  Eigen::VectorXd out(model.n_a());
  for (Eigen::Index j = 0; j < out.size(); ++j) out[j] = motors[static_cast<std::size_t>(j)].armature;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> J(6, model.n_a());
  for (const Link& link : model.links()) {
    const BodyInertia& body = model.inertias()[static_cast<std::size_t>(link.body)];
    const Pose& X_WB = kinematics.X_WB[static_cast<std::size_t>(link.body)];
    calc_point_jacobian(model, kinematics, link.body, X_WB * body.p_BCom, J);
    for (Eigen::Index j = 0; j < J.cols(); ++j) {
      const Vector3d angular_B = X_WB.R.transpose() * J.col(j).tail<3>();
      out[j] += body.mass * J.col(j).head<3>().squaredNorm() + angular_B.dot(body.inertia * angular_B);
    }
  }
  return out;
}

Eigen::VectorXd calc_largest_joint_inertia(const Model& model) {
  constexpr int kPostures = 100;
  KinematicsWorkspace work(model);
  Kinematics kinematics;
  core::Random random(0, 0);
  Eigen::VectorXd q = model.neutral(), largest = Eigen::VectorXd::Zero(model.n_a());
  for (int k = 0; k <= kPostures; ++k) {
    calc_kinematics(model, q, work, kinematics);
    largest = largest.cwiseMax(calc_joint_inertia(model, kinematics));
    for (int j = 0; j < model.n_a(); ++j) {
      const double lower = model.lower()[j], upper = model.upper()[j];
      const bool turns = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].kind == DofKind::Revolute;
      if (std::isfinite(lower) && std::isfinite(upper))
        q[model.n_qu() + j] = random.uniform(lower, upper);
      else if (turns)
        q[model.n_qu() + j] = random.uniform(-std::numbers::pi, std::numbers::pi);
    }
  }
  return largest;
}

void calc_gravity(const Model& model, const Kinematics& kinematics, Eigen::Ref<Eigen::VectorXd> tau_u) {
  const Model::Impl& m = model.impl();
  core::require_size("tau_u", tau_u.size(), m.n_vu);
  Eigen::Matrix<double, 3, 6> linear, angular;
  for (const ObjectNode& node : m.object_nodes) {
    tau_u.segment(node.v, node.n_v).setZero();
    for (const int o : node.carried) {
      const ObjectNode& moved = m.object_nodes[static_cast<std::size_t>(o)];
      calc_columns(m, kinematics, node, moved, linear, angular);
      const Vector3d force = moved.mass * moved.weight_share * m.scene.gravity;
      for (int i = 0; i < node.n_v; ++i) tau_u[node.v + i] += linear.col(i).dot(force);
    }
  }
}

void calc_object_derivatives(const Model& model, const Kinematics& kinematics, int object, VectorRef v,
                             Eigen::Ref<Eigen::MatrixXd> D_momentum_q, Eigen::Ref<Eigen::MatrixXd> D_gravity_q) {
  const Model::Impl& m = model.impl();
  const ObjectNode& node = m.object_nodes.at(static_cast<std::size_t>(object));
  core::require_size("v", v.size(), node.n_v);
  D_momentum_q.setZero();
  D_gravity_q.setZero();
  Eigen::Matrix<double, 3, 6> linear, angular, d_linear, d_angular;
  for (const int o : node.carried) {
    const ObjectNode& moved = m.object_nodes[static_cast<std::size_t>(o)];
    calc_columns(m, kinematics, node, moved, linear, angular);
    const Pose& X_WB = kinematics.X_WB[static_cast<std::size_t>(moved.body)];
    const Matrix3d inertia_W = X_WB.R * moved.inertia * X_WB.R.transpose();
    const Vector3d velocity = linear.leftCols(node.n_v) * v, rate = angular.leftCols(node.n_v) * v, spin = inertia_W * rate;
    for (std::size_t p = 0; p < m.object_nodes.size(); ++p) {
      const ObjectNode& mover = m.object_nodes[p];
      if (!carries(mover, o)) continue;  // a carrier moves `moved`, and also `node` unless it lies between the two
      for (int j = mover.v; j < mover.v + mover.n_v; ++j) {
        calc_column_rates(m, kinematics, node, mover, X_WB * moved.p_BCom, j, d_linear, d_angular);
        const Vector3d d_velocity = d_linear.leftCols(node.n_v) * v;
        Vector3d d_spin = inertia_W * (d_angular.leftCols(node.n_v) * v);
        if (m.dofs[static_cast<std::size_t>(j)].kind == DofKind::Revolute) {
          const Vector3d axis = kinematics.axis_W.col(j);
          d_spin += axis.cross(spin) - inertia_W * axis.cross(rate);
        }
        for (int i = 0; i < node.n_v; ++i) {
          D_momentum_q(i, j) += moved.mass * (d_linear.col(i).dot(velocity) + linear.col(i).dot(d_velocity)) + d_angular.col(i).dot(spin) +
                                angular.col(i).dot(d_spin);
          D_gravity_q(i, j) += moved.mass * moved.weight_share * d_linear.col(i).dot(m.scene.gravity);
        }
      }
    }
  }
}

}  // namespace stiction::world
