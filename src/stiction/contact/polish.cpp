#include "stiction/contact/polish.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stiction::contact::detail {
namespace {

constexpr double kNear = 0.05;  // features within this angle of the first normal are tried [rad]
constexpr int kMostFeatures = 24;

// A piece of the boundary of a convex core (a capsule counts as its axis), as its set of support points for directions d near
// one: point + Σ c_k dir_k, |c_k| ≤ half_k, + rim · P d / ‖P d‖ with P the projection square to rim_axis.
struct Feature {
  Vector3d point{0, 0, 0};
  int n_dirs = 0;
  Vector3d dir[2] = {Vector3d::Zero(), Vector3d::Zero()};
  double half[2] = {0, 0};
  bool disc = false;  // the two c_k lie in a circle of radius half[0]
  double rim = 0;
  Vector3d rim_axis{0, 0, 1};
  Vector3d normal{0, 0, 0};        // outward, of a face (n_dirs = 2)
  const MeshData* mesh = nullptr;  // of a face of a mesh, which bounds the c_k
  const Pose* X_WG = nullptr;

  Vector3d radial(const Vector3d& d) const {
    const Vector3d u = d - rim_axis * rim_axis.dot(d);
    return u.normalized();
  }
  Vector3d support(const Vector3d& d) const { return rim > 0 ? Vector3d(point + rim * radial(d)) : point; }
};

struct Features {
  std::array<Feature, kMostFeatures> list;
  int n = 0;
  void add(const Feature& f) {
    if (n < kMostFeatures) list[n++] = f;
  }
};

double core_support(const ShapeData& s, const Pose& X, const Vector3d& d) {
  const Vector3d l = X.R.transpose() * d;
  double h = d.dot(X.p);
  switch (s.kind) {
    case Kind::Capsule:
      return h + s.half.z() * std::abs(l.z());
    case Kind::Box:
      return h + s.half.dot(l.cwiseAbs());
    case Kind::Cylinder:
      return h + s.half.z() * std::abs(l.z()) + s.radius * std::hypot(l.x(), l.y());
    case Kind::Mesh:
      return h + (l.transpose() * s.mesh->vertices).maxCoeff();
    case Kind::Sphere:
    case Kind::HalfSpace:
      break;
  }
  return h;
}

double sign(double x) { return x < 0 ? -1.0 : 1.0; }

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

void add_mesh(const ShapeData& s, const Pose& X, const Vector3d& l, Features& out) {
  const MeshData& m = *s.mesh;
  const double top = (l.transpose() * m.vertices).maxCoeff(), low = top - kNear * 2.0 * m.radius;
  const auto is_near = [&](int v) { return l.dot(m.vertices.col(v)) > low; };
  for (std::size_t i = 0; i < m.face.size(); ++i) {
    const Eigen::Vector3i tri = m.triangles.col(m.face[i]);
    const auto k = static_cast<Eigen::Index>(i);
    const Vector3d normal(m.nx[k], m.ny[k], m.nz[k]);
    if (normal.cross(l).norm() < kNear && normal.dot(l) > 0) {
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

void find_features(const ShapeData& s, const Pose& X, const Vector3d& d, Features& out) {
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
      add_mesh(s, X, l, out);
      break;
    case Kind::Sphere:
    case Kind::HalfSpace:
      break;
  }
}

// Rank-one curvature of a rim: −∂p/∂d t tᵀ as it enters the second derivative of the separation.
double curvature(const Feature& f, const Vector3d& n, Vector3d& t) {
  if (f.rim <= 0) return 0.0;
  const Vector3d u = n - f.rim_axis * f.rim_axis.dot(n);
  const double length = u.norm();
  if (length < 1e-9) return 0.0;
  t = f.rim_axis.cross(u / length);
  return f.rim / length;
}

// Normal at which the separation between two features is stationary and a maximum, starting from n; false if there is none near.
bool find_normal(const Feature& a, const Feature& b, Vector3d& n) {
  const Vector3d start = n;
  if (a.n_dirs == 2 || b.n_dirs == 2) {
    n = a.n_dirs == 2 ? Vector3d(-a.normal) : b.normal;
    const Feature& other = a.n_dirs == 2 ? b : a;
    for (int k = 0; k < other.n_dirs; ++k) {
      if (std::abs(other.dir[k].dot(n)) > 1e-9) return false;
    }
  } else if (a.n_dirs + b.n_dirs == 2) {
    n = a.dir[0].cross(b.dir[0]);
    if (n.norm() < 1e-6) return false;
    n = n.normalized() * sign(n.dot(start));
  } else {
    const bool edge = a.n_dirs + b.n_dirs == 1;
    const Vector3d along = edge ? (a.n_dirs ? a.dir[0] : b.dir[0]) : Vector3d::Zero();
    if (edge) n = (n - along * along.dot(n)).normalized();
    bool done = false;
    for (int iteration = 0; iteration < 30 && !done; ++iteration) {
      Eigen::Matrix<double, 3, 2> T;
      T.col(0) = edge ? Vector3d(n.cross(along)) : Vector3d(n.unitOrthogonal());
      T.col(1) = n.cross(T.col(0));
      const Vector3d r = a.support(-n) - b.support(n);
      const double g = n.dot(r);
      Vector3d ta, tb;
      const double ca = curvature(a, n, ta), cb = curvature(b, n, tb);
      Eigen::Matrix2d H = g * Eigen::Matrix2d::Identity();  // minus the second derivative
      if (ca > 0) H += ca * (T.transpose() * ta) * (ta.transpose() * T);
      if (cb > 0) H += cb * (T.transpose() * tb) * (tb.transpose() * T);
      const Eigen::Vector2d gradient = T.transpose() * r;
      Eigen::Vector2d step(0, 0);
      if (edge) {
        if (H(0, 0) <= 0) return false;
        step[0] = gradient[0] / H(0, 0);
      } else {
        const double det = H(0, 0) * H(1, 1) - H(0, 1) * H(1, 0);
        if (H(0, 0) <= 0 || det <= 0) return false;
        step = Eigen::Vector2d(H(1, 1) * gradient[0] - H(0, 1) * gradient[1], H(0, 0) * gradient[1] - H(1, 0) * gradient[0]) / det;
      }
      const double size = step.norm();
      if (!std::isfinite(size)) return false;
      // Where the gap is small against the rim a full step overshoots: shorten it until the separation grows.
      double length = std::min(1.0, 0.1 / std::max(size, 1e-300));
      Vector3d next;
      for (int halving = 0; halving < 20; ++halving, length *= 0.5) {
        next = (n + T * step * length).normalized();
        if (size < 1e-5 || next.dot(a.support(-next) - b.support(next)) >= g) break;  // near the end rounding would decide
      }
      n = next;
      if (n.dot(start) < 0.95) return false;
      done = size < 1e-15;
    }
  }
  return n.dot(start) > 0.95;
}

// Points of the two features that lie on one line along n. False if they lie outside their features or are not unique.
bool find_points(const Feature& a, const Feature& b, const Vector3d& n, double scale, Vector3d& p_a, Vector3d& p_b) {
  p_a = a.support(-n);
  p_b = b.support(n);
  const int n_c = a.n_dirs + b.n_dirs;
  if (n_c > 2) return false;
  const Vector3d r = p_a - p_b;
  const Vector3d target = n * n.dot(r) - r;
  Eigen::Matrix<double, 3, 2> D = Eigen::Matrix<double, 3, 2>::Zero();
  for (int k = 0; k < a.n_dirs; ++k) D.col(k) = a.dir[k];
  for (int k = 0; k < b.n_dirs; ++k) D.col(a.n_dirs + k) = -b.dir[k];
  double c[2] = {0, 0};
  if (n_c == 1) c[0] = D.col(0).dot(target);
  if (n_c == 2) {
    const double d01 = D.col(0).dot(D.col(1)), det = 1.0 - d01 * d01;
    if (det < 1e-12) return false;
    const double b0 = D.col(0).dot(target), b1 = D.col(1).dot(target);
    c[0] = (b0 - d01 * b1) / det;
    c[1] = (b1 - d01 * b0) / det;
  }
  const double slack = 1e-9 * scale;
  int next = 0;
  for (const Feature* f : {&a, &b}) {
    Vector3d& p = f == &a ? p_a : p_b;
    for (int k = 0; k < f->n_dirs; ++k) p += c[next + k] * f->dir[k];
    if (f->mesh) {
      const Vector3d l = f->X_WG->R.transpose() * (p - f->X_WG->p);
      const MeshData& m = *f->mesh;
      for (Eigen::Index k = 0; k < m.d.size(); ++k) {
        if (m.nx[k] * l.x() + m.ny[k] * l.y() + m.nz[k] * l.z() > m.d[k] + slack) return false;
      }
    } else if (f->disc) {
      if (std::hypot(c[0], c[1]) > f->half[0] + slack) return false;
    } else {
      for (int k = 0; k < f->n_dirs; ++k) {
        if (std::abs(c[next + k]) > f->half[k] + slack) return false;
      }
    }
    next += f->n_dirs;
  }
  const Vector3d left = p_a - p_b;
  return (left - n * n.dot(left)).norm() < 1e-9 * scale;
}

}  // namespace

void polish(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, Distance& d) {
  const double r_a = a.kind == Kind::Capsule ? a.radius : 0.0, r_b = b.kind == Kind::Capsule ? b.radius : 0.0;
  const double scale = a.bounding_radius + b.bounding_radius;
  const auto separation = [&](const Vector3d& n) { return -core_support(a, X_WA, -n) - core_support(b, X_WB, n); };
  Features features_a, features_b;
  find_features(a, X_WA, -d.nhat_BA_W, features_a);
  find_features(b, X_WB, d.nhat_BA_W, features_b);

  // Every unit n gives a separation no larger than the distance: the largest among the stationary ones is it.
  Vector3d best_n = d.nhat_BA_W, best_middle = 0.5 * (d.p_WA + d.p_WB);
  double best = separation(best_n);
  bool matched = false;
  for (int i = 0; i < features_a.n; ++i) {
    for (int j = 0; j < features_b.n; ++j) {
      Vector3d n = d.nhat_BA_W, p_a, p_b;
      if (!find_normal(features_a.list[i], features_b.list[j], n)) continue;
      const double g = separation(n);
      // Where the two features are not the farthest ones along n, their own separation is larger than the true one.
      const bool points =
          find_points(features_a.list[i], features_b.list[j], n, scale, p_a, p_b) && std::abs(n.dot(p_a - p_b) - g) < 1e-11 * scale;
      // A match counts before a slightly larger separation without points: at a tie several pairs of features share the normal.
      const double tie = 1e-12 * scale;
      if (!(matched && !points ? g > best + tie : points && !matched ? g > best - tie : g > best)) continue;
      best = g;
      best_n = n;
      matched = points;
      if (points) best_middle = 0.5 * (p_a + p_b - r_a * n + r_b * n);
    }
  }
  d.phi = best - r_a - r_b;
  d.nhat_BA_W = best_n;
  if (!matched) {  // flat on flat: Coal's point, moved along n to the middle of the two support planes
    const double level = 0.5 * (-core_support(a, X_WA, -best_n) - r_a + core_support(b, X_WB, best_n) + r_b);
    best_middle = 0.5 * (d.p_WA + d.p_WB);
    best_middle += best_n * (level - best_n.dot(best_middle));
  }
  d.p_WA = best_middle + 0.5 * d.phi * best_n;
  d.p_WB = best_middle - 0.5 * d.phi * best_n;
}

}  // namespace stiction::contact::detail
