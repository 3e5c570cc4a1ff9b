#include "sensing_baselines/line_of_action.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>
#include <optional>

#include "stiction/core/invalid_input.hpp"

namespace stiction::bench {

using sensing::calc_link_jacobian;
using sensing::Surface;
using sensing::TriangleTree;

using Eigen::Index;
using Eigen::Vector3d;

namespace {

constexpr double kRankTolerance = 1e-6;  // smallest pivot over the largest of the wrench's map, which mixes metres and radians

/// Where the line through p along d meets a triangle; nothing where it runs beside or along it.
std::optional<Vector3d> intersect(const TriangleTree& tree, int triangle, const Vector3d& p, const Vector3d& d) {
  const Vector3d a = tree.corner(triangle, 0), u = tree.corner(triangle, 1) - a, v = tree.corner(triangle, 2) - a;
  Eigen::Matrix3d M;
  M << u, v, -d;
  const double determinant = M.determinant();
  if (determinant == 0) return std::nullopt;
  const Vector3d x = M.inverse() * (p - a);  // a + x₀ u + x₁ v = p + x₂ d
  if (!x.allFinite() || x[0] < 0 || x[1] < 0 || x[0] + x[1] > 1) return std::nullopt;
  return p + x[2] * d;
}

}  // namespace

std::string_view to_string(LineVerdict verdict) noexcept {
  switch (verdict) {
    case LineVerdict::BelowThreshold:
      return "below threshold";
    case LineVerdict::OtherLink:
      return "another link";
    case LineVerdict::RankDeficient:
      return "rank deficient";
    case LineVerdict::NoForce:
      return "no force";
    case LineVerdict::Misses:
      return "misses the link";
    case LineVerdict::Found:
      return "found";
  }
  return "";
}

LineOfAction find_line_of_action(const Sensor& sensor, VectorRef q, VectorRef tau, double epsilon) {
  const world::Model& model = sensor.model();
  core::require_size("q", q.size(), model.n_q());
  core::require_size("tau", tau.size(), model.n_a());
  core::require_finite("q", std::span(q.data(), static_cast<std::size_t>(q.size())));
  core::require_finite("tau", std::span(tau.data(), static_cast<std::size_t>(tau.size())));
  core::require_positive("epsilon", epsilon);
  LineOfAction out;
  Index last = tau.size() - 1;
  while (last >= 0 && !(std::abs(tau[last]) > epsilon)) --last;
  if (last < 0) return out;

  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  Eigen::Matrix3Xd J_w, J_v;
  out.verdict = LineVerdict::OtherLink;
  for (int k = 0; k < static_cast<int>(sensor.links().size()); ++k) {
    const Surface& surface = sensor.links()[static_cast<std::size_t>(k)].surface;
    calc_link_jacobian(model, kinematics, surface.body, J_w, J_v);
    Index moves = J_w.cols() - 1;
    while (moves >= 0 && J_w.col(moves).isZero(0) && J_v.col(moves).isZero(0)) --moves;
    if (moves != last) continue;

    Eigen::MatrixXd map(tau.size(), 6);
    map << J_w.transpose(), J_v.transpose();
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(map);
    qr.setThreshold(kRankTolerance);
    out.verdict = LineVerdict::RankDeficient;
    if (qr.rank() < 6) return out;
    const Eigen::Matrix<double, 6, 1> wrench = qr.solve(tau);
    const Vector3d m = wrench.head<3>(), f = wrench.tail<3>();
    out.verdict = LineVerdict::NoForce;
    if (f.isZero(0)) return out;
    const Vector3d p = f.cross(m) / f.squaredNorm();
    out.verdict = LineVerdict::Misses;
    for (int t = 0; t < surface.tree.size(); ++t) {
      const Vector3d n = surface.normals.col(t);
      if (!(f.dot(n) < 0)) continue;
      const auto hit = intersect(surface.tree, t, p, f);
      if (!hit) continue;
      out.points.push_back({.link = k, .triangle = t, .p_L = *hit, .n_L = n, .f_L = f, .residual = (map * wrench - tau).squaredNorm()});
    }
    if (!out.points.empty()) out.verdict = LineVerdict::Found;
    return out;
  }
  return out;
}

}  // namespace stiction::bench
