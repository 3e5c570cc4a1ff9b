#include "stiction/sensing/friction_cone.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {

using Eigen::Matrix3d;
using Eigen::Vector3d;

FrictionCone::FrictionCone(double friction, int rays) : friction_(friction), lorentz_(rays == 0) {
  core::require_nonnegative("friction", friction);
  if (rays != 0 && (rays < 3 || rays > kMostRays))
    core::throw_invalid("rays", std::to_string(rays), "0 (the exact cone), or 3 to " + std::to_string(kMostRays));
  if (friction == 0) {  // one ray, and no facets
    lorentz_ = false;
    rays_ = Vector3d::UnitX();
    facets_.resize(3, 0);
    fill_facet_rays();
    return;
  }
  rays_.resize(3, rays);
  facets_.resize(3, rays);
  for (int i = 0; i < rays; ++i) {
    const double angle = 2 * std::numbers::pi * i / rays;
    rays_.col(i) = Vector3d(1, friction * std::cos(angle), friction * std::sin(angle)).normalized();
  }
  for (int i = 0; i < rays; ++i) facets_.col(i) = Vector3d(rays_.col(i)).cross(Vector3d(rays_.col((i + 1) % rays)));
  fill_facet_rays();
}

void FrictionCone::fill_facet_rays() {
  const Eigen::Index n = rays_.cols();
  facet_rays_.resize(6, (n + 3) / 4 * 4);
  for (Eigen::Index i = 0; i < facet_rays_.cols(); ++i) facet_rays_.col(i) << rays_.col(i % n), rays_.col((i + 1) % n);
}

bool FrictionCone::contains(const Vector3d& f, double slack) const {
  const double most = slack * f.norm();
  if (lorentz_) return f.tail<2>().norm() <= friction_ * f[0] + most;
  if (facets_.cols() == 0) return f[0] >= -most && f.tail<2>().norm() <= most;
  for (const auto& m : facets_.colwise())
    if (m.dot(f) < -most * m.norm()) return false;
  return true;
}

Matrix3d make_contact_frame(const Vector3d& outward_normal) {
  const Vector3d k = -outward_normal;
  constexpr double kAlongZ = 1e-6;
  const bool along_z = k.head<2>().norm() < kAlongZ;
  Matrix3d R_LC;
  R_LC.col(0) = k;
  R_LC.col(1) = (along_z ? Vector3d(0, k.z(), -k.y()) : Vector3d(k.y(), -k.x(), 0)).normalized();
  R_LC.col(2) = k.cross(Vector3d(R_LC.col(1)));
  return R_LC;
}

}  // namespace stiction::sensing
