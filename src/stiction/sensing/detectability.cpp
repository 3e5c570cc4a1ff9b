#include "stiction/sensing/detectability.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

JointLine find_joint_line(const world::Model& model, int body) {
  world::Pose X_LB;  // of the link that the joint moves, in the frame asked for
  const auto link_of = [&](int b) -> const world::Link* {
    for (const auto& link : model.links())
      if (link.body == b) return &link;
    return nullptr;
  };
  for (const world::Link* link = link_of(body); link != nullptr; link = link_of(link->parent)) {
    if (link->dof < 0) {
      X_LB = X_LB * link->X_PJ.inverse();
      continue;
    }
    const auto kind = link->follower < 0 ? model.dofs()[static_cast<std::size_t>(link->dof)].kind
                                         : model.followers()[static_cast<std::size_t>(link->follower)].kind;
    return {X_LB.R * link->axis, X_LB.p, kind == world::DofKind::Prismatic, link->dof - static_cast<int>(model.n_vu())};
  }
  core::throw_invalid("link", "'" + model.bodies()[static_cast<std::size_t>(body)].name + "'", "a link of a robot that a joint moves");
}

Detectability classify(const Vector3d& lever, const Matrix3d& R_LC, const FrictionCone& cone) {
  if (lever.isZero(0)) return Detectability::Undetectable;
  const Vector3d m = R_LC.transpose() * lever;
  if (cone.is_lorentz()) {
    const double least = cone.friction() / std::hypot(1.0, cone.friction());
    return std::abs(m[0]) > least * m.norm() ? Detectability::Full : Detectability::Partial;
  }
  const Eigen::VectorXd torques = cone.ray_matrix().transpose() * m;
  if (torques.isZero(0)) return Detectability::Undetectable;
  return torques.minCoeff() > 0 || torques.maxCoeff() < 0 ? Detectability::Full : Detectability::Partial;
}

double calc_cap_intersection(double a, double b, double d) {
  const double smaller = 2 * pi * (1 - std::cos(std::min(a, b)));
  if (d >= a + b) return 0;
  if (d <= std::abs(a - b)) return smaller;                                              // one in the other
  if (a + b + d >= 2 * pi) return std::max(0.0, 2 * pi * (-std::cos(a) - std::cos(b)));  // together they cover the sphere
  // Two circular segments around the spherical triangle of the axes and a point in which the circles meet.
  const double ca = std::cos(a), cb = std::cos(b), cd = std::cos(d), sa = std::sin(a), sb = std::sin(b), sd = std::sin(d);
  const auto angle = [](double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)); };
  const double at_point = angle((cd - ca * cb) / (sa * sb)), at_a = angle((cb - cd * ca) / (sd * sa)),
               at_b = angle((ca - cd * cb) / (sd * sb));
  return std::clamp(2 * (pi - at_point - at_a * ca - at_b * cb), 0.0, smaller);
}

double calc_undetectability(const Vector3d& lever, const Vector3d& k, double friction, double epsilon) {
  core::require_positive("epsilon", epsilon);
  const double length = lever.norm();
  if (epsilon >= length) return 1;
  if (friction == 0) return std::abs(lever.dot(k)) <= epsilon ? 1 : 0;
  const double cap = std::atan(friction), band = epsilon / length;
  const double d = std::atan2(lever.cross(k).norm(), lever.dot(k));
  const double below = calc_cap_intersection(cap, std::acos(-band), d), above = calc_cap_intersection(cap, std::acos(band), d);
  return std::clamp((below - above) / (2 * pi * (1 - std::cos(cap))), 0.0, 1.0);
}

DetectabilityMap calc_detectability(const world::Model& model, const SensedLink& link, const FrictionCone& cone, double epsilon) {
  const JointLine line = find_joint_line(model, link.surface.body);
  DetectabilityMap out;
  out.eta.resize(link.batch.size);
  for (Eigen::Index i = 0; i < link.batch.size; ++i) {
    const Matrix3d R_LC = link.batch.R_LC(i);
    const Vector3d lever = line.lever(link.batch.p_L(i));
    out.kinds.push_back(classify(lever, R_LC, cone));
    out.full += out.kinds.back() == Detectability::Full;
    out.eta[i] = calc_undetectability(lever, R_LC.col(0), cone.friction(), epsilon);
  }
  return out;
}

}  // namespace stiction::sensing
