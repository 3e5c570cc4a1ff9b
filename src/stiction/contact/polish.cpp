#include "stiction/contact/polish.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/contact/feature_pair.hpp"
#include "stiction/contact/polytope.hpp"

namespace stiction::contact::detail {
namespace {

constexpr double kNear = 0.05;      // features within this angle of the first normal are tried [rad]
constexpr double kNearest = 1e-3;   // the same for a first try on meshes [rad]: a round part has too many features within kNear
constexpr double kCertain = 2e-11;  // tolerance at which phi has reached its upper bound, as a share of the sizes
constexpr double kSame =
    1e-3;  // largest error of the first witness points, as a share of the sizes; beyond it some pairs of features are tried in vain
constexpr int kMostRounds = 60;            // most rounds of projections back and forth
constexpr std::size_t kMostVertices = 32;  // all edges of a mesh are tried up to this number of vertices

/// A pair of shapes at their poses, as cores with a radius.
struct Pair {
  const ShapeData& a;
  const Pose& X_WA;
  const ShapeData& b;
  const Pose& X_WB;
  double r_a, r_b, scale, bound;

  double separation(const Vector3d& n) const { return -core_support(a, X_WA, -n) - core_support(b, X_WB, n); }
};

struct Answer {
  Vector3d n{0, 0, 0};
  double separation = -1e300;  // separation of the cores along n
  Vector3d middle{0, 0, 0};    // midpoint of the witness points
  bool matched = false;        // the witness points lie on two features

  // Whether no better answer exists. If the shapes are apart, the distance of the matched points equals the separation, which is a lower
  // bound of the distance. In overlap, the separation has reached the upper bound.
  bool is_certain(const Pair& pair) const { return matched && (separation > 0 || separation >= pair.bound - kCertain * pair.scale); }

  void offer(const Pair& pair, const Vector3d& normal, bool points, const Vector3d& p_a, const Vector3d& p_b) {
    const double g = pair.separation(normal);
    // If the two features are not the farthest ones along n, their own separation is larger than the true one.
    points = points && std::abs(normal.dot(p_a - p_b) - g) < 1e-11 * pair.scale;
    // A match is preferred to a slightly larger separation without points: at a tie several pairs of features share the normal.
    const double tie = 1e-12 * pair.scale;
    if (!(matched && !points ? g > separation + tie : points && !matched ? g > separation - tie : g > separation)) return;
    n = normal;
    separation = g;
    matched = points;
    if (points) middle = 0.5 * (p_a + p_b - pair.r_a * n + pair.r_b * n);
  }
};

// Finds the best answer among the pairs of features near `start`. The separation along any unit n is at most the distance, so the largest
// stationary separation is the distance.
Answer refine(const Pair& pair, const Vector3d& start, double near, Features features_a, Features features_b) {
  find_features(pair.a, pair.X_WA, -start, near, features_a);
  find_features(pair.b, pair.X_WB, start, near, features_b);
  Answer best{.n = start, .separation = pair.separation(start)};
  for (int i = 0; i < features_a.size(); ++i) {
    for (int j = 0; j < features_b.size(); ++j) {
      const Feature &a = features_a[i], &b = features_b[j];
      Vector3d n = start, p_a, p_b;
      if (find_normal(a, b, n)) {
        const bool points = find_points(a, b, n, pair.scale, p_a, p_b);
        best.offer(pair, n, points, p_a, p_b);
      }
      if (best.is_certain(pair)) return best;
      const bool flat_a = is_flat_rim(a, start), flat_b = is_flat_rim(b, start);
      if (!(flat_a || flat_b) || a.n_dirs + a.rim == 0 || b.n_dirs + b.rim == 0 || a.n_dirs == 2 || b.n_dirs == 2) continue;
      Vector3d starts[2];
      const int n_starts = flat_a ? find_starts(a, b, start, start, starts) : find_starts(b, a, start, -start, starts);
      for (int k = 0; k < n_starts; ++k) {
        n = start;
        if (find_crossing(a, b, starts[k], n, p_a, p_b)) best.offer(pair, n, true, p_a, p_b);
        if (best.is_certain(pair)) return best;
      }
    }
  }
  return best;
}

Answer refine(const Pair& pair, const Vector3d& start, const Features& of_a, const Features& of_b) {
  if (pair.a.kind == Kind::Mesh || pair.b.kind == Kind::Mesh) {
    const Answer nearest = refine(pair, start, kNearest, of_a, of_b);
    if (nearest.is_certain(pair)) return nearest;
  }
  return refine(pair, start, kNear, of_a, of_b);
}

// Visits the outward normals of the flat faces of a shape, in W.
template <class Visit>
void for_each_normal(const ShapeData& s, const Pose& X, Visit visit) {
  if (!s.polytope) return;
  for (const Polytope::Face& face : s.polytope->faces) visit(Vector3d(X.R * face.normal));
}

// Visits the directions of the straight edges of a shape and the axis of a round shape, in W. Large meshes are left out: they have too many
// edges.
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

// Direction with the largest separation among the candidates (6a): normals of faces and caps, common perpendiculars of edges and axes, and
// the line of the centres, also made perpendicular to each axis.
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
  for (const auto* side : {&pair.a, &pair.b}) {  // for centres on one axis, the line of the centres gives no way out to the side
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

// Witness point of two flat features on each other, which is not unique. A is moved along n until the two shapes just touch; the result is
// the middle of the two points that projecting back and forth reaches from `start`.
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

}  // namespace

void polish(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, double bound, Distance& d) {
  const double r_a = core_radius(a), r_b = core_radius(b);
  const Pair pair{a, X_WA, b, X_WB, r_a, r_b, a.bounding_radius + b.bounding_radius, bound};
  const double same = kSame * pair.scale;
  Answer best = refine(pair, d.nhat_BA_W, Features(d.p_WA + r_a * d.nhat_BA_W, same), Features(d.p_WB - r_b * d.nhat_BA_W, same));
  // The answer may belong to another way out of the overlap. If a candidate direction separates more than the answer, the search restarts
  // there.
  if (!best.is_certain(pair)) {
    double canonical = best.separation + 1e-12 * pair.scale;
    const Vector3d start = find_canonical(pair, canonical);
    if (start.squaredNorm() > 0) best = refine(pair, start, {}, {});
  }
  d.phi = best.separation - r_a - r_b;
  d.nhat_BA_W = best.n;
  if (!best.matched) best.middle = find_common_point(pair, best, 0.5 * (d.p_WA + d.p_WB));
  d.p_WA = best.middle + 0.5 * d.phi * best.n;
  d.p_WB = best.middle - 0.5 * d.phi * best.n;
}

}  // namespace stiction::contact::detail
