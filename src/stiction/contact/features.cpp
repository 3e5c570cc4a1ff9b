#include "stiction/contact/features.hpp"

#include <cmath>

namespace stiction::contact::detail {
namespace {

constexpr double kNear = 0.05;  // of all shapes but meshes: features within this angle are tried [rad]

// Along each axis a feature of a box extends (0) or lies at an end (±1); near 0 the sign of the slope cannot be trusted.
void add_box(const ShapeData& s, const Pose& X, const Vector3d& l, Features& out) {
  const auto possible = [&](int i, int at) { return std::abs(l[i]) < kNear || at == sign(l[i]); };
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const int at[3] = {x, y, z};
        if (!possible(0, x) || !possible(1, y) || !possible(2, z) || (!x && !y && !z)) continue;
        Feature f;
        f.point = X * Vector3d(x * s.half.x(), y * s.half.y(), z * s.half.z());
        for (int i = 0; i < 3; ++i) {
          if (at[i]) continue;
          f.dir[f.n_dirs] = X.R.col(i);
          f.half[f.n_dirs++] = s.half[i];
        }
        if (f.n_dirs == 2) f.normal = X.R * Vector3d(x, y, z);
        out.add(f);
      }
    }
  }
}

// The axis of a capsule (rim = 0) or the side and the rims of a cylinder.
void add_segment(const ShapeData& s, const Pose& X, const Vector3d& l, double rim, Features& out) {
  const Vector3d axis = X.R.col(2);
  const bool level = std::abs(l.z()) < kNear;
  for (const double end : {-1.0, 1.0}) {
    if (!level && end != sign(l.z())) continue;
    Feature f;
    f.rim = rim;
    f.rim_axis = axis;
    f.point = X.p + end * s.half.z() * axis;
    out.add(f);
  }
  if (!level) return;
  Feature f;
  f.rim = rim;
  f.rim_axis = axis;
  f.point = X.p;
  f.n_dirs = 1;
  f.dir[0] = axis;
  f.half[0] = s.half.z();
  out.add(f);
}

void add_cap(const ShapeData& s, const Pose& X, const Vector3d& l, Features& out) {
  if (std::hypot(l.x(), l.y()) >= kNear) return;
  Feature f;
  f.normal = sign(l.z()) * X.R.col(2);
  f.point = X.p + s.half.z() * f.normal;
  f.n_dirs = 2;
  f.dir[0] = X.R.col(0);
  f.dir[1] = X.R.col(1);
  f.half[0] = f.half[1] = s.radius;
  f.disc = true;
  out.add(f);
}

void add_mesh(const ShapeData& s, const Pose& X, const Vector3d& l, double near, Features& out) {
  const MeshData& m = *s.mesh;
  const double top = l.dot(m.vertices.col(find_vertex(m, l))), low = top - near * 2.0 * m.radius;
  const auto is_near = [&](int v) { return l.dot(m.vertices.col(v)) > low; };
  for (std::size_t i = 0; i < m.face.size(); ++i) {
    const Eigen::Vector3i tri = m.triangles.col(m.face[i]);
    const auto k = static_cast<Eigen::Index>(i);
    const Vector3d normal(m.nx[k], m.ny[k], m.nz[k]);
    if (normal.dot(l) > 0 && normal.cross(l).squaredNorm() < near * near) {
      Feature f;
      f.normal = X.R * normal;
      f.point = X * m.vertices.col(tri[0]);
      f.n_dirs = 2;
      f.dir[0] = X.R * (m.vertices.col(tri[1]) - m.vertices.col(tri[0])).normalized();
      f.dir[1] = f.normal.cross(f.dir[0]);
      f.mesh = &m;  // the face may be larger than this triangle
      f.X_WG = &X;
      out.add(f);
    }
    for (int e = 0; e < 3; ++e) {
      const int v = tri[e], w = tri[(e + 1) % 3];
      if (v > w || !is_near(v) || !is_near(w)) continue;  // each edge has one triangle with v < w
      const Vector3d along = m.vertices.col(w) - m.vertices.col(v);
      Feature f;
      f.point = X * Vector3d(0.5 * (m.vertices.col(v) + m.vertices.col(w)));
      f.n_dirs = 1;
      f.dir[0] = X.R * along.normalized();
      f.half[0] = 0.5 * along.norm();
      out.add(f);
    }
  }
  for (Eigen::Index v = 0; v < m.vertices.cols(); ++v) {
    if (!is_near(static_cast<int>(v))) continue;
    Feature f;
    f.point = X * m.vertices.col(v);
    out.add(f);
  }
}

}  // namespace

void find_features(const ShapeData& s, const Pose& X, const Vector3d& d, double near, Features& out) {
  const Vector3d l = X.R.transpose() * d;
  switch (s.kind) {
    case Kind::Capsule:
      add_segment(s, X, l, 0.0, out);
      break;
    case Kind::Box:
      add_box(s, X, l, out);
      break;
    case Kind::Cylinder:
      add_segment(s, X, l, s.radius, out);
      add_cap(s, X, l, out);
      break;
    case Kind::Mesh:
      add_mesh(s, X, l, near, out);
      break;
    case Kind::Sphere:
    case Kind::HalfSpace:
      break;
  }
}

}  // namespace stiction::contact::detail
