#include "stiction/world/scales.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/world/model.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// An axis along which less than this share of gravity acts counts as level. Files round the directions of axes.
constexpr double kLevel = 0.01;

/// ∫ r rᵀ dm about the centre of mass, from the inertia about it.
Matrix3d second_moments(const Matrix3d& inertia) { return 0.5 * inertia.trace() * Matrix3d::Identity() - inertia; }

/// Body axis normal to the plane in which a planar object moves; −1 for other joints.
int planar_normal(ObjectJoint joint) {
  switch (joint) {
    case ObjectJoint::PlanarXY:
      return 2;
    case ObjectJoint::PlanarXZ:
      return 1;
    case ObjectJoint::PlanarYZ:
      return 0;
    case ObjectJoint::Free:
    case ObjectJoint::Hinge:
    case ObjectJoint::Slider:
      return -1;
  }
  return -1;
}

double calc_length(const ObjectSpec& spec) {
  std::vector<GeometrySpec> solids;
  for (const auto& g : spec.geometries) {
    if (!std::holds_alternative<HalfSpace>(g.shape)) solids.push_back(g);
  }
  const VolumeProperties volume = solids.empty() ? VolumeProperties{spec.mass, spec.p_BCom, spec.inertia} : calc_volume_properties(solids);
  const Matrix3d C = 12 * second_moments(volume.inertia) / volume.volume;
  const int normal = planar_normal(spec.joint);
  if (normal >= 0) {
    const int i = (normal + 1) % 3, j = (normal + 2) % 3;
    const double det = C(i, i) * C(j, j) - C(i, j) * C(j, i);
    if (det > 0) return std::sqrt(std::sqrt(det));
  } else if (const double det = C.determinant(); det > 0) {
    return std::cbrt(std::sqrt(det));
  }
  return std::sqrt(C.trace() / 3);  // the inertia of a flat body
}

/// Part of gravity along the motion of an object: along its sliding axes, or across the axis of a hinge.
Vector3d gravity_along(const Model& model, const Kinematics& kinematics, const ObjectInfo& object) {
  const Vector3d& gravity = model.scene().gravity;
  Vector3d along = Vector3d::Zero();
  bool slides = false;
  for (int v = object.v_begin; v < object.v_begin + object.n_v; ++v) {
    if (model.dofs()[at(v)].kind != DofKind::Prismatic) continue;
    const Vector3d axis = kinematics.axis_W.col(v);
    along += axis.dot(gravity) * axis;
    slides = true;
  }
  if (slides) return along;
  const Vector3d axis = kinematics.axis_W.col(object.v_begin);
  return gravity - axis.dot(gravity) * axis;
}

/// K_a/reach² of the softest joint [N/m], 0 without joints.
double calc_softest(const Model& model) {
  double softest = std::numeric_limits<double>::infinity();
  for (int j = 0; j < model.n_a(); ++j) {
    const bool revolute = model.dofs()[at(model.n_vu() + j)].kind == DofKind::Revolute;
    const double arm = revolute ? model.reach()[j] : 1.0;
    softest = std::min(softest, model.stiffness()[j] / (arm * arm));
  }
  return std::isfinite(softest) ? softest : 0.0;
}

/// Diameter of the largest ball around a shape of a robot link [m]; the longest reach if there is no such shape.
double calc_robot_length(const Model& model) {
  double length = 0;
  for (const auto& geometry : model.geometries()) {
    const bool robot = model.bodies()[at(geometry.body)].kind == BodyKind::Robot;
    if (robot && std::isfinite(geometry.bounding_radius)) length = std::max(length, 2 * geometry.bounding_radius);
  }
  return length > 0 || model.n_a() == 0 ? length : model.reach().maxCoeff();
}

}  // namespace

Scales::Scales(const Model& model) : softest_(calc_softest(model)) {
  const Vector3d& gravity = model.scene().gravity;
  const double spring = share::kSpringTravel * softest_;
  KinematicsWorkspace work(model);
  Kinematics kinematics;
  calc_kinematics(model, model.neutral(), work, kinematics);
  for (std::size_t o = 0; o < model.objects().size(); ++o) {
    const ObjectInfo& object = model.objects()[o];
    const ObjectSpec& spec = model.scene().objects[o];
    const double length = calc_length(spec);
    const double g = gravity_along(model, kinematics, object).norm();
    const double weight = g > kLevel * gravity.norm() ? object.carried_mass * g : 0.0;
    const double friction = spec.joint_friction / (spec.joint == ObjectJoint::Hinge ? length : 1.0);
    const double force = std::max(weight, friction);
    const double fallback = gravity.isZero(0) ? length : gravity.norm();
    objects_.push_back({length, force > 0 ? force : (spring > 0 ? spring * length : object.carried_mass * fallback)});
  }
  const auto least = [](Scale a, const Scale& b) { return Scale{std::min(a.length, b.length), std::min(a.force, b.force)}; };
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  robots_ = {kInfinity, kInfinity};
  for (const Scale& object : objects_) robots_ = least(robots_, object);
  if (objects_.empty()) {
    const double length = calc_robot_length(model);
    robots_ = {length, spring * length};
  }
  joints_.resize(model.n_a());
  for (int j = 0; j < model.n_a(); ++j) joints_[j] = model.dofs()[at(model.n_vu() + j)].kind == DofKind::Revolute ? 1.0 : robots_.length;
  for (const auto& pair : model.pairs()) {
    Scale scale{kInfinity, kInfinity};
    for (const int g : {pair.geometry_a, pair.geometry_b}) {
      const Body& body = model.bodies()[at(model.geometries()[at(g)].body)];
      if (body.kind == BodyKind::Object) scale = least(scale, objects_[at(body.owner)]);
    }
    pairs_.push_back(std::isfinite(scale.length) ? scale : robots_);
  }
}

double Scales::kappa(int i) const { return 2 / (share::kLift * object(i).length * object(i).force); }

double Scales::gamma(int i) const { return share::kMetric * object(i).length * object(i).length; }

}  // namespace stiction::world
