#include "stiction/world/object_space.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace stiction::world {
namespace {

/// Axes (first, second, normal) of a planar joint, in cyclic order.
std::array<int, 3> planar_axes(ObjectJoint joint) {
  switch (joint) {
    case ObjectJoint::PlanarXY:
      return {0, 1, 2};
    case ObjectJoint::PlanarYZ:
      return {1, 2, 0};
    case ObjectJoint::PlanarXZ:
      return {0, 2, 1};
    default:
      return {-1, -1, -1};
  }
}

bool is_planar(ObjectJoint joint) { return planar_axes(joint)[0] >= 0; }

/// Angle of a rotation about a unit axis (the twist of its swing–twist decomposition).
double angle_about(const Eigen::Matrix3d& R, const Eigen::Vector3d& axis) {
  const Eigen::Quaterniond q(R);
  return 2.0 * std::atan2(q.vec().dot(axis), q.w());
}

double wrap(double angle) { return std::abs(angle) <= std::numbers::pi ? angle : std::remainder(angle, 2.0 * std::numbers::pi); }

/// 2·acos(w)/√(1 − w²) for 0 ≤ w ≤ 1, the factor from the vector part of a quaternion to its rotation vector, accurate to 4e-8 [-]. With
/// acos(w) = √(1 − w)·P(w) (Abramowitz & Stegun 4.4.46) the formula has no singularity and calls no trigonometric function. Such calls would take
/// half of the time of the search for the nearest node.
double log_factor(double w) {
  constexpr double kP[8] = {1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
                            0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911};
  double p = kP[7];
  for (int i = 6; i >= 0; --i) p = p * w + kP[i];
  return 2 * p / std::sqrt(1 + w);
}

/// Rotation vector of conj(a) · b for unit quaternions stored x, y, z, w: the shorter way round.
void rotation_between(const double* a, const double* b, double* e) {
  const double w = a[3] * b[3] + a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const double k = std::copysign(log_factor(std::min(std::abs(w), 1.0)), w);
  e[0] = k * (a[3] * b[0] - a[0] * b[3] - (a[1] * b[2] - a[2] * b[1]));
  e[1] = k * (a[3] * b[1] - a[1] * b[3] - (a[2] * b[0] - a[0] * b[2]));
  e[2] = k * (a[3] * b[2] - a[2] * b[3] - (a[0] * b[1] - a[1] * b[0]));
}

}  // namespace

ObjectSpace::ObjectSpace(const Model& model) : n_q_(model.n_qu()), n_v_(model.n_vu()) {
  const auto objects = model.objects();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto& spec = model.scene().objects[i];
    blocks_.push_back({spec.joint, objects[i].q_begin, objects[i].v_begin, spec.X_WP, spec.axis.normalized()});
  }
}

void ObjectSpace::error(const double* from, const double* to, double* e) const {
  for (const Block& b : blocks_) {
    const double* f = from + b.q_begin;
    const double* t = to + b.q_begin;
    double* out = e + b.v_begin;
    if (b.joint == ObjectJoint::Free) {
      for (int i = 0; i < 3; ++i) out[i] = t[i] - f[i];
      rotation_between(f + 3, t + 3, out + 3);
    } else if (is_planar(b.joint)) {
      out[0] = t[0] - f[0];
      out[1] = t[1] - f[1];
      out[2] = wrap(t[2] - f[2]);
    } else {
      out[0] = t[0] - f[0];
    }
  }
}

Eigen::VectorXd ObjectSpace::coordinates(int object, const Pose& X_WB) const {
  const Block& b = blocks_[static_cast<std::size_t>(object)];
  if (b.joint == ObjectJoint::Free) {
    Eigen::VectorXd q(7);
    q << X_WB.p, Eigen::Quaterniond(X_WB.R).normalized().coeffs();
    return q;
  }
  const Pose X_PB = b.X_WP.inverse() * X_WB;
  if (is_planar(b.joint)) {
    const auto axes = planar_axes(b.joint);
    // Although x × z = −y, the angle in the xz plane is about +y (docs/notation.md).
    Eigen::VectorXd q(3);
    q << X_PB.p[axes[0]], X_PB.p[axes[1]], angle_about(X_PB.R, Eigen::Vector3d::Unit(axes[2]));
    return q;
  }
  Eigen::VectorXd q(1);
  q[0] = b.joint == ObjectJoint::Hinge ? angle_about(X_PB.R, b.axis) : b.axis.dot(X_PB.p);
  return q;
}

void ObjectSpace::sample(const std::vector<SampleBox>& boxes, core::Random& random, Eigen::Ref<Eigen::VectorXd> q_u) const {
  for (const SampleBox& box : boxes) {
    const Block& b = blocks_[static_cast<std::size_t>(box.object)];
    Eigen::VectorXd x(box.lower.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = random.uniform(box.lower[i], box.upper[i]);
    if (b.joint != ObjectJoint::Free) {
      q_u.segment(b.q_begin, x.size()) = x;
      continue;
    }
    const Eigen::Quaterniond rotation = Eigen::AngleAxisd(x[5], Eigen::Vector3d::UnitZ()) *
                                        Eigen::AngleAxisd(x[4], Eigen::Vector3d::UnitY()) *
                                        Eigen::AngleAxisd(x[3], Eigen::Vector3d::UnitX());
    q_u.segment<3>(b.q_begin) = x.head<3>();
    q_u.segment<4>(b.q_begin + 3) = rotation.coeffs();
  }
}

double nearest_turn(double angle, double reference) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return angle - kTurn * std::round((angle - reference) / kTurn);
}

double largest_share(const Model& model, const Eigen::VectorXd& e, double position, double angle) {
  double share = 0;
  for (const auto& object : model.objects()) {
    double position2 = 0, angle2 = 0;
    for (int i = object.v_begin; i < object.v_begin + object.n_v; ++i) {
      const bool revolute = model.dofs()[static_cast<std::size_t>(i)].kind == DofKind::Revolute;
      (revolute ? angle2 : position2) += e[i] * e[i];
    }
    share = std::max({share, std::sqrt(position2) / position, std::sqrt(angle2) / angle});
  }
  return share;
}

bool objects_agree(const Model& model, const ObjectSpace& space, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1, double position,
                   double angle) {
  Eigen::VectorXd e(model.n_vu());
  space.error(q0.data(), q1.data(), e.data());
  return largest_share(model, e, position, angle) <= 1;
}

}  // namespace stiction::world
