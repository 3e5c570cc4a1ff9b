#include "stiction/world/ellipsoid.hpp"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "stiction/world/shapes.hpp"

namespace stiction::world {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Points of the unit sphere: an icosahedron whose edges are halved twice.
std::vector<Vector3d> make_sphere_points() {
  const double t = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vector3d> points;
  for (const auto& [a, b] : {std::pair{-1.0, t}, {1.0, t}, {-1.0, -t}, {1.0, -t}}) points.emplace_back(Vector3d(a, b, 0).normalized());
  for (const auto& [a, b] : {std::pair{-1.0, t}, {1.0, t}, {-1.0, -t}, {1.0, -t}}) points.emplace_back(Vector3d(0, a, b).normalized());
  for (const auto& [a, b] : {std::pair{t, -1.0}, {t, 1.0}, {-t, -1.0}, {-t, 1.0}}) points.emplace_back(Vector3d(a, 0, b).normalized());
  std::vector<Vector3i> faces{{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                              {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                              {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < 2; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [found, added] = middle.try_emplace(std::minmax(a, b), static_cast<int>(points.size()));
      if (added) points.push_back((points[static_cast<std::size_t>(a)] + points[static_cast<std::size_t>(b)]).normalized());
      return found->second;
    };
    std::vector<Vector3i> finer;
    for (const Vector3i& f : faces) {
      const int a = between(f[0], f[1]), b = between(f[1], f[2]), c = between(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
    }
    faces = std::move(finer);
  }
  return points;
}

}  // namespace

ConvexMesh make_ellipsoid(const Vector3d& radii) {
  static const std::vector<Vector3d> kPoints = make_sphere_points();
  Eigen::Matrix3Xd corners(3, static_cast<Eigen::Index>(kPoints.size()));
  for (std::size_t i = 0; i < kPoints.size(); ++i)
    corners.col(static_cast<Eigen::Index>(i)) = (1 + kEllipsoidError) * radii.cwiseProduct(kPoints[i]);
  return make_convex_hull(corners);
}

}  // namespace stiction::world
