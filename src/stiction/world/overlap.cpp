#include "stiction/world/overlap.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {
namespace {

using Eigen::Vector3d;

/// Point of a shape that lies farthest along d.
Vector3d support(const Shape& shape, const Vector3d& d) {
  const auto sign = [](double x) { return x < 0 ? -1.0 : 1.0; };
  return std::visit(
      core::Overloaded{
          [&](const Sphere& s) -> Vector3d { return s.radius * d.normalized(); },
          [&](const Capsule& s) -> Vector3d { return s.radius * d.normalized() + sign(d.z()) * s.half_length * Vector3d::UnitZ(); },
          [&](const Box& s) -> Vector3d { return d.unaryExpr(sign).cwiseProduct(s.half_extents); },
          [&](const Cylinder& s) -> Vector3d {
            const double length = d.head<2>().norm();
            const Eigen::Vector2d rim = length > 0 ? Eigen::Vector2d(s.radius / length * d.head<2>()) : Eigen::Vector2d::Zero();
            return {rim.x(), rim.y(), sign(d.z()) * s.half_length};
          },
          [](const HalfSpace&) -> Vector3d { core::throw_invalid("shape", "a half-space", "a bounded shape"); },
          [&](const Mesh& s) -> Vector3d {
            Eigen::Index farthest = 0;
            (d.transpose() * s.mesh->vertices).maxCoeff(&farthest);
            return s.mesh->vertices.col(farthest);
          },
      },
      shape);
}

/// Keeps only the points whose hull has the point nearest to 0 in its interior, and returns that nearest point.
Vector3d reduce(std::vector<Vector3d>& points) {
  Vector3d best = points.back();
  std::vector<Vector3d> kept{points.back()};
  const auto n = static_cast<unsigned>(points.size());
  for (unsigned subset = 1; subset < 1u << n; ++subset) {
    std::vector<Vector3d> chosen;
    for (unsigned i = 0; i < n; ++i) {
      if (subset >> i & 1) chosen.push_back(points[i]);
    }
    // Nearest point p₀ + E t of the affine hull.
    Eigen::Matrix3Xd E(3, static_cast<Eigen::Index>(chosen.size()) - 1);
    for (Eigen::Index i = 0; i < E.cols(); ++i) E.col(i) = chosen[static_cast<std::size_t>(i) + 1] - chosen[0];
    const Eigen::VectorXd t = E.cols() > 0 ? Eigen::VectorXd(E.colPivHouseholderQr().solve(-chosen[0])) : Eigen::VectorXd();
    if (t.size() > 0 && (t.minCoeff() < 0 || t.sum() > 1)) continue;
    const Vector3d nearest = t.size() > 0 ? Vector3d(chosen[0] + E * t) : chosen[0];
    if (nearest.squaredNorm() >= best.squaredNorm()) continue;
    best = nearest;
    kept = std::move(chosen);
  }
  points = std::move(kept);
  return best;
}

}  // namespace

bool overlap(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  constexpr int kMaxIterations = 64;
  const BoundingSphere ball_a = calc_bounding_sphere(a), ball_b = calc_bounding_sphere(b);
  const double touch = 1e-6 * (ball_a.radius + ball_b.radius);
  Vector3d v = X_WA * ball_a.center - X_WB * ball_b.center;
  if (v.norm() > ball_a.radius + ball_b.radius + touch) return false;
  if (v.norm() <= touch) v = touch * Vector3d::UnitX();
  std::vector<Vector3d> simplex;
  for (int k = 0; k < kMaxIterations; ++k) {
    const Vector3d w = X_WA * support(a, X_WA.R.transpose() * -v) - X_WB * support(b, X_WB.R.transpose() * v);
    const double bound = v.dot(w) / v.norm();  // lower bound of the distance
    if (bound > touch) return false;
    if (k > 0 && v.norm() - bound <= 0.1 * touch) return true;  // the distance itself, ≤ touch
    simplex.push_back(w);
    v = reduce(simplex);
    if (v.norm() <= touch || simplex.size() == 4) return true;
  }
  return true;
}

}  // namespace stiction::world
