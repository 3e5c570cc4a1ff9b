#include "stiction/contact/features.hpp"

#include <algorithm>
#include <cmath>

namespace stiction::contact::detail {
namespace {

constexpr int kMostWalked = 64;  // largest number of mesh corners that are visited
constexpr double kNear = 0.05;   // features of shapes other than meshes within this angle are tried [rad]

// Lower bound of the distance from p to a feature.
double distance(const Feature& f, const Vector3d& p) {
  const Vector3d d = p - f.point;
  if (f.n_dirs == 2) {
    const double height = std::abs(f.normal.dot(d)), x = std::abs(f.dir[0].dot(d)), y = std::abs(f.dir[1].dot(d));
    if (f.mesh) return height;
    return height + (f.disc ? std::max(0.0, std::hypot(x, y) - f.half[0]) : std::max({0.0, x - f.half[0], y - f.half[1]}));
  }
  if (f.n_dirs == 1) return std::abs((d - std::clamp(f.dir[0].dot(d), -f.half[0], f.half[0]) * f.dir[0]).norm() - f.rim);
  if (f.rim <= 0) return d.norm();
  const double height = f.rim_axis.dot(d);
  return std::hypot(height, (d - height * f.rim_axis).norm() - f.rim);
}

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

void add_face(const MeshData& m, int plane, const Pose& X, Features& out) {
  const Eigen::Vector3i tri = m.triangles.col(m.face[plane]);
  Feature f;
  f.normal = X.R * Vector3d(m.nx[plane], m.ny[plane], m.nz[plane]);
  f.point = X * m.vertices.col(tri[0]);
  f.n_dirs = 2;
  f.dir[0] = X.R * (m.vertices.col(tri[1]) - m.vertices.col(tri[0])).normalized();
  f.dir[1] = f.normal.cross(f.dir[0]);
  f.mesh = &m;  // the face may be larger than this triangle
  f.X_WG = &X;
  out.add(f);
}

void add_edge(const MeshData& m, int v, int w, const Pose& X, Features& out) {
  const Vector3d along = m.vertices.col(w) - m.vertices.col(v);
  Feature f;
  f.point = X * Vector3d(0.5 * (m.vertices.col(v) + m.vertices.col(w)));
  f.n_dirs = 1;
  f.dir[0] = X.R * along.normalized();
  f.half[0] = 0.5 * along.norm();
  out.add(f);
}

// The corners near the top are connected, so a walk over edges from the highest corner visits all of them.
void add_mesh(const ShapeData& s, const Pose& X, const Vector3d& l, double near, Features& out) {
  const MeshData& m = *s.mesh;
  const int highest = find_vertex(m, l);
  const double low = l.dot(m.vertices.col(highest)) - near * 2.0 * m.radius;
  const auto is_near = [&](int v) { return l.dot(m.vertices.col(v)) > low; };
  std::array<int, kMostWalked> walked{highest};
  int n = 1;
  for (int at = 0; at < n; ++at) {
    const int v = walked[at];
    Feature corner;
    corner.point = X * m.vertices.col(v);
    out.add(corner);
    for (int k = m.begin[v]; k < m.begin[v + 1]; ++k) {
      const int plane = m.around[k];
      const Eigen::Vector3i tri = m.triangles.col(m.face[plane]);
      const int e = tri[0] == v ? 0 : tri[1] == v ? 1 : 2, w = tri[(e + 1) % 3], x = tri[(e + 2) % 3];
      const Vector3d normal(m.nx[plane], m.ny[plane], m.nz[plane]);
      const bool is_first = std::none_of(walked.begin(), walked.begin() + at, [&](int y) { return y == w || y == x; });
      if (is_first && normal.dot(l) > 0 && normal.cross(l).squaredNorm() < near * near) add_face(m, plane, X, out);
      if (!is_near(w)) continue;
      const auto seen = std::find(walked.begin(), walked.begin() + n, w);
      if (seen - walked.begin() > at) add_edge(m, v, w, X, out);  // once per edge, from the corner visited first
      if (seen == walked.begin() + n && n < kMostWalked) walked[n++] = w;
    }
  }
}

}  // namespace

double Features::rank(const Feature& f) const {
  if (!sorted_) return 0;
  const double off = distance(f, at_);
  return off <= same_ ? f.n_dirs - 3 : off;
}

void Features::add(const Feature& f) {
  const double rank = this->rank(f);
  if (n_ == kMostFeatures && rank >= rank_[n_ - 1]) return;
  const int place = n_ < kMostFeatures ? n_++ : place_[n_ - 1];
  list_[place] = f;
  int k = n_ - 1;
  for (; k > 0 && rank < rank_[k - 1]; --k) rank_[k] = rank_[k - 1], place_[k] = place_[k - 1];
  rank_[k] = rank;
  place_[k] = place;
}

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
