#include "stiction/contact/minkowski.hpp"

namespace stiction::contact::detail {
namespace {

/// Farthest point of a core along d; the point and d are in the frame of the shape.
int find_corner(const ShapeData& s, const Vector3d& d, Vector3d& p) {
  switch (s.kind) {
    case Kind::Capsule:
      p = {0, 0, sign(d.z()) * s.half.z()};
      return d.z() < 0;
    case Kind::Box:
      p = {sign(d.x()) * s.half.x(), sign(d.y()) * s.half.y(), sign(d.z()) * s.half.z()};
      return (d.x() < 0) + 2 * (d.y() < 0) + 4 * (d.z() < 0);
    case Kind::Mesh: {
      const int i = find_vertex(*s.mesh, d);
      p = s.mesh->vertices.col(i);
      return i;
    }
    case Kind::Cylinder: {
      const double length = std::hypot(d.x(), d.y()), scale = length > 0 ? s.radius / length : 0.0;
      p = {scale * d.x(), scale * d.y(), sign(d.z()) * s.half.z()};
      return -1;
    }
    case Kind::Sphere:
    case Kind::HalfSpace:
      break;
  }
  p.setZero();
  return 0;
}

}  // namespace

Minkowski::Minkowski(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB)
    : a_(a), b_(b), R_(X_WA.R.transpose() * X_WB.R), p_(X_WA.R.transpose() * (X_WB.p - X_WA.p)) {}

void Minkowski::find_farthest(const Vector3d& d, Corner& out) const {
  Vector3d b;
  out.i = find_corner(a_, d, out.a);
  out.j = find_corner(b_, R_.transpose() * -d, b);
  out.b = R_ * b + p_;
  out.w = out.a - out.b;
}

}  // namespace stiction::contact::detail
