#include "stiction/sensing/tessellate.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "stiction/core/overloaded.hpp"

namespace stiction::sensing {

using Eigen::Matrix3Xd;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

class Triangles {
 public:
  void add(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    corners_.push_back(a);
    corners_.push_back(b);
    corners_.push_back(c);
  }
  Matrix3Xd take() const {
    Matrix3Xd out(3, static_cast<Eigen::Index>(corners_.size()));
    for (std::size_t i = 0; i < corners_.size(); ++i) out.col(static_cast<Eigen::Index>(i)) = corners_[i];
    return out;
  }

 private:
  std::vector<Vector3d> corners_;
};

/// A profile (radius, z), from below to above, turned about z.
Matrix3Xd revolve(const std::vector<Vector2d>& profile, int segments) {
  Triangles out;
  const auto at = [&](const Vector2d& rz, int i) {
    const double angle = 2 * std::numbers::pi * (i % segments) / segments;
    return Vector3d(rz[0] * std::cos(angle), rz[0] * std::sin(angle), rz[1]);
  };
  for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
    const Vector2d &low = profile[k], &high = profile[k + 1];
    for (int i = 0; i < segments; ++i) {
      if (low[0] > 0) out.add(at(low, i), at(low, i + 1), at(high, i + 1));
      if (high[0] > 0) out.add(at(low, i), at(high, i + 1), at(high, i));
    }
  }
  return out.take();
}

/// Quarter circles from pole to equator, as in the sphere (half_length 0) and the capsule.
Matrix3Xd make_capsule(double radius, double half_length, int segments) {
  const int steps = std::max(1, segments / 4);
  std::vector<Vector2d> profile;
  const auto add = [&](int i, double z) {
    const double latitude = 0.5 * std::numbers::pi * i / steps;
    profile.emplace_back(std::abs(i) == steps ? 0 : radius * std::cos(latitude), z + radius * std::sin(latitude));
  };
  for (int i = -steps; i <= 0; ++i) add(i, -half_length);
  for (int i = half_length > 0 ? 0 : 1; i <= steps; ++i) add(i, half_length);
  return revolve(profile, segments);
}

Matrix3Xd make_box(const Vector3d& half) {
  Triangles out;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto corner = [&](double x, double y) {
        Vector3d p;
        p[axis] = side * half[axis];
        p[u] = x * half[u];
        p[v] = side * y * half[v];  // mirrored: so that both sides wind outwards
        return p;
      };
      out.add(corner(-1, -1), corner(1, -1), corner(1, 1));
      out.add(corner(-1, -1), corner(1, 1), corner(-1, 1));
    }
  }
  return out.take();
}

Matrix3Xd triangles_of(const world::ConvexMesh& mesh) {
  if (mesh.surface) return *mesh.surface;
  Matrix3Xd out(3, 3 * mesh.triangles.cols());
  for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
    for (int k = 0; k < 3; ++k) out.col(3 * t + k) = mesh.vertices.col(mesh.triangles(k, t));
  return out;
}

}  // namespace

Matrix3Xd tessellate(const world::Shape& shape, int segments) {
  return std::visit(
      core::Overloaded{
          [&](const world::Sphere& s) { return make_capsule(s.radius, 0, segments); },
          [&](const world::Capsule& s) { return make_capsule(s.radius, s.half_length, segments); },
          [&](const world::Cylinder& s) {
            return revolve({{0, -s.half_length}, {s.radius, -s.half_length}, {s.radius, s.half_length}, {0, s.half_length}}, segments);
          },
          [&](const world::Box& s) { return make_box(s.half_extents); },
          [&](const world::HalfSpace&) { return Matrix3Xd(3, 0); },
          [&](const world::Mesh& s) { return triangles_of(*s.mesh); },
      },
      shape);
}

}  // namespace stiction::sensing
