#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "stiction/world/shapes.hpp"
#include "world/mesh_files.hpp"

// Convex parts against the surface that they stand for.

namespace stiction::world::test {

inline double volume_of(const ConvexMesh& mesh) { return calc_volume_properties(Mesh{std::make_shared<const ConvexMesh>(mesh)}).volume; }

inline double volume_of(const std::vector<ConvexMesh>& parts) {
  double sum = 0;
  for (const auto& part : parts) sum += volume_of(part);
  return sum;
}

/// How far a point lies outside the planes of the nearest part; ≤ 0 inside one. A lower bound of the distance.
inline double outside(const std::vector<ConvexMesh>& parts, const Eigen::Vector3d& p) {
  double least = 1e300;
  for (const ConvexMesh& part : parts) {
    double most = -1e300;
    for (Eigen::Index t = 0; t < part.triangles.cols(); ++t) {
      const Eigen::Vector3d a = part.vertices.col(part.triangles(0, t)), b = part.vertices.col(part.triangles(1, t)),
                            c = part.vertices.col(part.triangles(2, t));
      most = std::max(most, (b - a).cross(c - a).normalized().dot(p - a));
    }
    least = std::min(least, most);
  }
  return least;
}

/// The farthest that corners, and the centres of edges and triangles, lie outside the parts.
inline double surface_gap(const std::vector<ConvexMesh>& parts, const ObjMesh& mesh) {
  double gap = 0;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(t[k % 3])]; };
    gap = std::max(gap, outside(parts, (corner(0) + corner(1) + corner(2)) / 3));
    for (int k = 0; k < 3; ++k) gap = std::max({gap, outside(parts, corner(k)), outside(parts, (corner(k) + corner(k + 1)) / 2)});
  }
  return gap;
}

}  // namespace stiction::world::test
