#include "stiction/execution/touch/approach.hpp"

#include <cmath>
#include <limits>

#include "stiction/contact/contact.hpp"

namespace stiction::execution {

namespace {

/// Distance of the nearest shapes of two bodies, the first body displaced.
contact::Distance calc_nearest(const world::Model& model, const world::Kinematics& kinematics, int link, int body,
                               const Eigen::Vector3d& moved) {
  contact::Distance nearest;
  nearest.phi = std::numeric_limits<double>::infinity();
  for (const world::Geometry& a : model.geometries()) {
    if (a.body != link) continue;
    for (const world::Geometry& b : model.geometries()) {
      if (b.body != body) continue;
      world::Pose X_WA = kinematics.X_WB[static_cast<std::size_t>(link)] * a.X_BG;
      X_WA.p += moved;
      const contact::Distance d = contact::calc_distance(a.shape, X_WA, b.shape, kinematics.X_WB[static_cast<std::size_t>(body)] * b.X_BG);
      if (d.phi < nearest.phi) nearest = d;
    }
  }
  return nearest;
}

}  // namespace

std::optional<double> calc_approach(const world::Model& model, const Eigen::VectorXd& q, int link, int body,
                                    const Eigen::Vector3d& direction_W, double gap, double start) {
  constexpr int kSteps = 50;
  constexpr double kClose = 1e-7;       // [m]
  constexpr double kLeastSlope = 0.05;  // with a smaller slope, the direction leads along the surface
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  double along = start;
  for (int i = 0; i < kSteps; ++i) {
    const contact::Distance d = calc_nearest(model, kinematics, link, body, along * direction_W);
    if (!std::isfinite(d.phi)) return std::nullopt;
    if (std::abs(d.phi - gap) < kClose) return along;
    const double slope = d.nhat_BA_W.dot(direction_W);
    if (!(-slope > kLeastSlope)) return std::nullopt;
    along -= (d.phi - gap) / slope;
  }
  return std::nullopt;
}

}  // namespace stiction::execution
