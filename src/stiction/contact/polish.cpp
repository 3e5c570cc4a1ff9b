#include "stiction/contact/polish.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "stiction/contact/polytope.hpp"

namespace stiction::contact::detail {
namespace {

constexpr double kNear = 0.05;       // features within this angle of the first normal are tried [rad],
constexpr double kNearest = 1e-3;    // of meshes first those within this one: a round part has more than are tried within the other
constexpr double kParallel = 1e-13;  // sine of the angle below which two edges are parallel [-]: what they lose is this share of them
constexpr int kMostFeatures = 24;
constexpr int kMostRounds = 60;            // of projections back and forth
constexpr std::size_t kMostVertices = 32;  // of a mesh whose edges are all tried

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
    // Twice, because for d near the axis the first difference keeps few digits.
    const Vector3d u = (d - rim_axis * rim_axis.dot(d)).normalized();
    return (u - rim_axis * rim_axis.dot(u)).normalized();
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

void add_mesh(const ShapeData& s, const Pose& X, const Vector3d& l, double near, Features& out) {
  const MeshData& m = *s.mesh;
  const double top = (l.transpose() * m.vertices).maxCoeff(), low = top - near * 2.0 * m.radius;
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

// Rank-one curvature of a rim: −∂p/∂d t tᵀ as it enters the second derivative of the separation.
double curvature(const Feature& f, const Vector3d& n, Vector3d& t) {
  if (f.rim <= 0) return 0.0;
  const Vector3d u = n - f.rim_axis * f.rim_axis.dot(n);
  const double length = u.norm();
  if (length < 1e-9) return 0.0;
  t = f.rim_axis.cross(u / length);
  return f.rim / length;
}

// The same by Newton's method, where the normal is not that of a face or of two edges.
bool climb(const Feature& a, const Feature& b, Vector3d& n) {
  const Vector3d start = n;
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
  return n.dot(start) > 0.95;
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
    if (n.norm() < kParallel) return false;
    // Between nearly parallel edges the cross product has few digits. Square to one of them n has an error that keeps it square to both.
    n = (n - a.dir[0] * a.dir[0].dot(n)).normalized();
    n = (n - a.dir[0] * a.dir[0].dot(n)).normalized();
    n *= sign(n.dot(start));
  } else {
    return climb(a, b, n);
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
    const Vector3d across = n.cross(D.col(0));  // stays accurate where the two are nearly parallel
    const double sine = across.dot(D.col(1));
    if (std::abs(sine) < kParallel) return false;
    c[1] = across.dot(target) / sine;
    c[0] = D.col(0).dot(target - c[1] * D.col(1));
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

// A rim, edge or axis as a curve p(t).
struct Curve {
  const Feature& f;
  Vector3d e1{0, 0, 0}, e2{0, 0, 0};  // of a rim: radius vectors at 0 and a quarter turn
  bool round = false;
  double t = 0;

  explicit Curve(const Feature& feature) : f(feature), round(feature.n_dirs == 0) {
    e1 = f.rim * f.rim_axis.unitOrthogonal();
    e2 = f.rim_axis.cross(e1);
  }
  Vector3d radius() const { return std::cos(t) * e1 + std::sin(t) * e2; }
  Vector3d at() const { return round ? Vector3d(f.point + radius()) : Vector3d(f.point + t * f.dir[0]); }
  Vector3d tangent() const { return round ? Vector3d(std::cos(t) * e2 - std::sin(t) * e1) : f.dir[0]; }
  Vector3d bend() const { return round ? Vector3d(-radius()) : Vector3d::Zero(); }
  void move_near(const Vector3d& p) { t = round ? std::atan2(e2.dot(p - f.point), e1.dot(p - f.point)) : f.dir[0].dot(p - f.point); }
  double offset() const { return round ? 0.0 : f.rim; }  // the surface is this far from the curve
};

constexpr double kFlatRim = 0.2;  // sine of the angle between a normal and the axis below which a rim is seen as a circle

bool is_flat_rim(const Feature& f, const Vector3d& n) { return f.n_dirs == 0 && f.rim > 0 && f.rim_axis.cross(n).norm() < kFlatRim; }

// Where the circle of a flat rim meets another flat rim, or the line along another feature, seen along n.
int find_starts(const Feature& rim, const Feature& other, const Vector3d& n, const Vector3d& towards, Vector3d out[2]) {
  Vector3d foot, along;  // of the line through both points, seen along n
  if (is_flat_rim(other, n)) {
    Vector3d r = other.point - rim.point;
    r -= n * n.dot(r);
    const double length = r.norm();
    if (length < 1e-12 * rim.rim) return 0;
    foot = rim.point + r * (0.5 * (length * length + rim.rim * rim.rim - other.rim * other.rim) / (length * length));
    along = n.cross(r) / length;
  } else {
    along = other.n_dirs ? other.dir[0] : other.rim_axis.cross(other.radial(towards));
    along = (along - n * n.dot(along)).normalized();
    const Vector3d p = other.support(towards);
    foot = p + along * along.dot(rim.point - p);
  }
  Vector3d off = foot - rim.point;
  off -= n * n.dot(off);
  const double rest = rim.rim * rim.rim - off.squaredNorm();
  if (rest < 0) return 0;
  out[0] = foot + std::sqrt(rest) * along;
  out[1] = foot - std::sqrt(rest) * along;
  return 2;
}

// A rim seen along its axis turns by any angle with a small turn of n, so that n is no coordinate there. The places on both curves
// are: the line between them is square to both. False if Newton's method does not end in such a line near `start`.
bool find_crossing(Curve a, Curve b, const Vector3d& near, Vector3d& n, Vector3d& p_a, Vector3d& p_b) {
  const Vector3d start = n;
  a.move_near(near);
  b.move_near(near);
  bool done = false;
  for (int iteration = 0; iteration < 20 && !done; ++iteration) {
    const Vector3d d = a.at() - b.at(), u = a.tangent(), v = b.tangent();
    Eigen::Matrix2d J;
    J << u.squaredNorm() + d.dot(a.bend()), -u.dot(v), u.dot(v), d.dot(b.bend()) - v.squaredNorm();
    const double det = J.determinant();
    if (std::abs(det) < 1e-12 * u.squaredNorm() * v.squaredNorm()) return false;
    const Eigen::Vector2d f(d.dot(u), d.dot(v));
    const Eigen::Vector2d step = Eigen::Vector2d(J(1, 1) * f[0] - J(0, 1) * f[1], J(0, 0) * f[1] - J(1, 0) * f[0]) / det;
    a.t -= step[0];
    b.t -= step[1];
    if (!step.allFinite()) return false;
    done = std::abs(step[0]) * u.norm() + std::abs(step[1]) * v.norm() < 1e-14 * (u.norm() + v.norm());
  }
  if (!a.round && std::abs(a.t) > a.f.half[0]) return false;
  if (!b.round && std::abs(b.t) > b.f.half[0]) return false;
  const double offset = a.offset() + b.offset();
  n = offset > 0 ? Vector3d(a.at() - b.at()) : Vector3d(a.tangent().cross(b.tangent()));
  n = n.normalized() * sign(n.dot(start));
  p_a = a.at() - a.offset() * n;
  p_b = b.at() + b.offset() * n;
  return n.dot(start) > 0.95;
}

/// A pair of shapes in their places, as cores with a radius.
struct Pair {
  const ShapeData& a;
  const Pose& X_WA;
  const ShapeData& b;
  const Pose& X_WB;
  double r_a, r_b, scale;

  double separation(const Vector3d& n) const { return -core_support(a, X_WA, -n) - core_support(b, X_WB, n); }
};

struct Answer {
  Vector3d n{0, 0, 0};
  double separation = -1e300;  // of the cores along n
  Vector3d middle{0, 0, 0};    // between the witness points
  bool matched = false;        // two features meet there

  // The points are as far apart as the separation, which no distance is below: nothing can be better.
  bool is_certain() const { return matched && separation > 0; }

  void offer(const Pair& pair, const Vector3d& normal, bool points, const Vector3d& p_a, const Vector3d& p_b) {
    const double g = pair.separation(normal);
    // Where the two features are not the farthest ones along n, their own separation is larger than the true one.
    points = points && std::abs(normal.dot(p_a - p_b) - g) < 1e-11 * pair.scale;
    // A match counts before a slightly larger separation without points: at a tie several pairs of features share the normal.
    const double tie = 1e-12 * pair.scale;
    if (!(matched && !points ? g > separation + tie : points && !matched ? g > separation - tie : g > separation)) return;
    n = normal;
    separation = g;
    matched = points;
    if (points) middle = 0.5 * (p_a + p_b - pair.r_a * n + pair.r_b * n);
  }
};

// The best answer that pairs of features near `start` give. Every unit n gives a separation no larger than the distance: the largest
// among the stationary ones is it.
Answer refine(const Pair& pair, const Vector3d& start, double near) {
  Features features_a, features_b;
  find_features(pair.a, pair.X_WA, -start, near, features_a);
  find_features(pair.b, pair.X_WB, start, near, features_b);
  Answer best{.n = start, .separation = pair.separation(start)};
  for (int i = 0; i < features_a.n; ++i) {
    for (int j = 0; j < features_b.n; ++j) {
      const Feature &a = features_a.list[i], &b = features_b.list[j];
      Vector3d n = start, p_a, p_b;
      if (find_normal(a, b, n)) {
        const bool points = find_points(a, b, n, pair.scale, p_a, p_b);
        best.offer(pair, n, points, p_a, p_b);
      }
      if (best.is_certain()) return best;
      const bool flat_a = is_flat_rim(a, start), flat_b = is_flat_rim(b, start);
      if (!(flat_a || flat_b) || a.n_dirs + a.rim == 0 || b.n_dirs + b.rim == 0 || a.n_dirs == 2 || b.n_dirs == 2) continue;
      Vector3d starts[2];
      const int n_starts = flat_a ? find_starts(a, b, start, start, starts) : find_starts(b, a, start, -start, starts);
      for (int k = 0; k < n_starts; ++k) {
        n = start;
        if (find_crossing(Curve(a), Curve(b), starts[k], n, p_a, p_b)) best.offer(pair, n, true, p_a, p_b);
        if (best.is_certain()) return best;
      }
    }
  }
  return best;
}

Answer refine(const Pair& pair, const Vector3d& start) {
  if (pair.a.kind == Kind::Mesh || pair.b.kind == Kind::Mesh) {
    const Answer nearest = refine(pair, start, kNearest);
    if (nearest.is_certain()) return nearest;
  }
  return refine(pair, start, kNear);
}

// Visits the outward normals of the flat faces of a shape, in W.
template <class Visit>
void for_each_normal(const ShapeData& s, const Pose& X, Visit visit) {
  if (!s.polytope) return;
  for (const Polytope::Face& face : s.polytope->faces) visit(Vector3d(X.R * face.normal));
}

// Visits the directions of the straight edges of a shape and the axis of a round one, in W. Large meshes have too many of them.
template <class Visit>
void for_each_edge(const ShapeData& s, const Pose& X, Visit visit) {
  if (s.kind == Kind::Capsule || s.kind == Kind::Cylinder) visit(Vector3d(X.R.col(2)));
  if (s.kind == Kind::Box) {
    for (int k = 0; k < 3; ++k) visit(Vector3d(X.R.col(k)));
  }
  if (s.kind != Kind::Mesh || s.polytope->vertices.size() > kMostVertices) return;
  for (const Polytope::Face& face : s.polytope->faces) {
    for (int k = 0; k < face.count; ++k) {
      const int v = s.polytope->loop[face.begin + k], w = s.polytope->loop[face.begin + (k + 1) % face.count];
      if (v < w) visit(Vector3d(X.R * (s.polytope->vertices[w] - s.polytope->vertices[v]).normalized()));
    }
  }
}

// The direction with the largest separation among those that both shapes single out: normals of faces and caps, common
// perpendiculars of edges and axes, and the line of the centres, also square to each axis.
Vector3d find_canonical(const Pair& pair, double& best) {
  Vector3d out{0, 0, 0};
  const auto meet = [&](const Vector3d& n) {
    const double g = pair.separation(n);
    if (g > best) best = g, out = n;
  };
  const auto meet_both = [&](const Vector3d& d) {
    const double length = d.norm();
    if (length < 1e-9) return;
    meet(d / length);
    meet(-d / length);
  };
  for_each_normal(pair.a, pair.X_WA, [&](const Vector3d& n) { meet(-n); });
  for_each_normal(pair.b, pair.X_WB, meet);
  const Vector3d line = pair.X_WA * pair.a.p_GCenter - pair.X_WB * pair.b.p_GCenter;
  meet_both(line);
  for_each_edge(pair.a, pair.X_WA,
                [&](const Vector3d& u) { for_each_edge(pair.b, pair.X_WB, [&](const Vector3d& v) { meet_both(u.cross(v)); }); });
  for (const auto* side : {&pair.a, &pair.b}) {  // on one axis the line of the centres says nothing of the way out to the side
    const Pose& X = side == &pair.a ? pair.X_WA : pair.X_WB;
    if (side->kind == Kind::Cylinder || side->kind == Kind::Capsule) meet_both(X.R.col(0));
  }
  if (pair.a.kind == Kind::Cylinder) meet_both(line - pair.X_WA.R.col(2) * pair.X_WA.R.col(2).dot(line));
  if (pair.b.kind == Kind::Cylinder) meet_both(line - pair.X_WB.R.col(2) * pair.X_WB.R.col(2).dot(line));
  return out;
}

// The point of a core that is nearest to p.
Vector3d project(const ShapeData& s, const Pose& X, const Vector3d& p) {
  static const ShapeData point;
  static const KernelContext context;
  const Kernel kernel = find_kernel(Kind::Sphere, s.kind);
  if (s.kind == Kind::Capsule) {
    const Vector3d axis = X.R.col(2);
    return X.p + std::clamp(axis.dot(p - X.p), -s.half.z(), s.half.z()) * axis;
  }
  Distance d;
  kernel(point, {Eigen::Matrix3d::Identity(), p}, s, X, context, d);
  return d.phi > 0 ? d.p_WB : p;
}

// Flat on flat has no unique witness: the middle between the points that projecting back and forth reaches from `start`, with A moved
// along n until the two only touch.
Vector3d find_common_point(const Pair& pair, const Answer& best, const Vector3d& start) {
  const Vector3d shift = best.separation * best.n;
  Vector3d y = start - best.n * best.n.dot(start) + best.n * core_support(pair.b, pair.X_WB, best.n);
  for (int round = 0; round < kMostRounds; ++round) {
    const Vector3d on_b = project(pair.b, pair.X_WB, y), x = project(pair.a, pair.X_WA, on_b + shift) - shift;
    y = x;
    if ((x - on_b).norm() < 1e-14 * pair.scale) break;
  }
  y += best.n * (core_support(pair.b, pair.X_WB, best.n) - best.n.dot(y));
  return y + 0.5 * (best.separation + pair.r_b - pair.r_a) * best.n;
}

/// Deeper than this is doubtful, as a share of the smaller body's radius [-]: an answer of a shallower overlap errs by less than that, for
/// separations along all directions are lower bounds.
constexpr double kDeep = 0.05;
/// Largest difference between a distance and the separation along its normal, as a share of the sizes of both [-].
constexpr double kConsistent = 1e-9;
/// Coal rounds smaller distances to nothing, as a share of the same [-].
constexpr double kTouching = 1e-7;

}  // namespace

bool is_doubtful(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const Distance& d) {
  if (!std::isfinite(d.phi) || !d.nhat_BA_W.allFinite()) return true;
  if (d.phi < -kDeep * std::min(a.bounding_radius, b.bounding_radius)) return true;
  const double sizes = a.bounding_radius + b.bounding_radius;
  if (std::abs(d.phi) < kTouching * sizes) return true;
  const double separation = -support(a, X_WA, -d.nhat_BA_W) - support(b, X_WB, d.nhat_BA_W);
  return std::abs(d.phi - separation) > kConsistent * sizes;
}

void polish(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, Distance& d) {
  const double r_a = core_radius(a), r_b = core_radius(b);
  const Pair pair{a, X_WA, b, X_WB, r_a, r_b, a.bounding_radius + b.bounding_radius};
  if (!std::isfinite(d.phi) || !d.nhat_BA_W.allFinite()) {  // Coal gave nothing: start anywhere
    const Vector3d line = X_WA * a.p_GCenter - X_WB * b.p_GCenter;
    d.nhat_BA_W = line.squaredNorm() > 0 ? Vector3d(line.normalized()) : Vector3d::UnitZ();
    d.p_WA = d.p_WB = 0.5 * (X_WA * a.p_GCenter + X_WB * b.p_GCenter);
  }
  Answer best = refine(pair, d.nhat_BA_W);
  // Coal is sometimes wrong by millimetres. A direction that separates more than its answer does starts the search again.
  if (!best.is_certain()) {
    double canonical = best.separation + 1e-12 * pair.scale;
    const Vector3d start = find_canonical(pair, canonical);
    if (start.squaredNorm() > 0) best = refine(pair, start);
  }
  d.phi = best.separation - r_a - r_b;
  d.nhat_BA_W = best.n;
  if (!best.matched) best.middle = find_common_point(pair, best, 0.5 * (d.p_WA + d.p_WB));
  d.p_WA = best.middle + 0.5 * d.phi * best.n;
  d.p_WB = best.middle - 0.5 * d.phi * best.n;
}

}  // namespace stiction::contact::detail
