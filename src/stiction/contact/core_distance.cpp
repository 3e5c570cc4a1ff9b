#include "stiction/contact/core_distance.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "stiction/contact/minkowski.hpp"
#include "stiction/contact/polish.hpp"
#include "stiction/contact/polytope.hpp"

namespace stiction::contact::detail {
namespace {

constexpr double kTolerance = 1e-14;  // tolerance of GJK and EPA, as a share of the sizes [-]. Polytopes end on an exact feature;
// around a cylinder they only give the start of polish(), with n̂ accurate to 1e-3 rad at gaps of a thousandth.
constexpr double kCurvedGap = 1e-9, kCurvedDepth = 1e-11;
constexpr double kConsistent = 1e-11;  // largest difference between the two bounds of a proven answer, as a share of the sizes [-]
constexpr double kParallel = 1e-13;    // sine of the angle below which two edges give no normal [-]

/// The distinct corners of one core in a simplex.
template <class Index>
int count(const Simplex& s, const Index& index) {
  int n = 0;
  for (int k = 0; k < s.n; ++k) {
    bool seen = false;
    for (int l = 0; l < k; ++l) seen = seen || index(s.corner[l]) == index(s.corner[k]);
    n += !seen;
  }
  return n;
}

/// An edge of one core, in the axes of A, between its first two distinct corners.
template <class Index, class Point>
Vector3d find_edge(const Simplex& s, const Index& index, const Point& point) {
  for (int k = 1; k < s.n; ++k) {
    if (index(s.corner[k]) != index(s.corner[0])) return point(s.corner[k]) - point(s.corner[0]);
  }
  return Vector3d::Zero();
}

/// A direction and the separation (1) along it.
struct Best {
  Vector3d n{0, 0, 1};
  double g = -std::numeric_limits<double>::infinity();
  void offer(const Minkowski& c, const Vector3d& normal) {
    const double separation = -c.height(-normal);
    if (separation > g) g = separation, n = normal;
  }
};

/// Normal from two crossing edges or from a face of the nearest features. It is more accurate than a short vector between the nearest
/// points.
void refine(const Minkowski& c, const Simplex& s, Best& best) {
  const auto of_a = [](const Corner& k) { return k.i; };
  const auto of_b = [](const Corner& k) { return k.j; };
  const int n_a = count(s, of_a), n_b = count(s, of_b);
  if (s.n == 2) {
    const Vector3d along = (s.corner[1].w - s.corner[0].w).normalized();
    best.offer(c, (best.n - along * along.dot(best.n)).normalized());
  }
  const Vector3d n = best.n;
  if (n_a >= 3 && c.a().polytope) best.offer(c, -c.a().polytope->faces[find_face(*c.a().polytope, -n)].normal);
  if (n_b >= 3 && c.b().polytope) {
    best.offer(c, c.R_AB() * c.b().polytope->faces[find_face(*c.b().polytope, c.R_AB().transpose() * n)].normal);
  }
  if (n_a < 2 || n_b < 2) return;
  const Vector3d u = find_edge(s, of_a, [](const Corner& k) { return k.a; }).normalized();
  Vector3d m = u.cross(find_edge(s, of_b, [](const Corner& k) { return k.b; }).normalized());
  if (m.norm() < kParallel) return;
  // If m is made perpendicular to one edge, its remaining error keeps it perpendicular to both.
  m = (m - u * u.dot(m)).normalized();
  m = (m - u * u.dot(m)).normalized();
  best.offer(c, m.dot(n) < 0 ? Vector3d(-m) : m);
}

/// Turns the answer for the cores in `simplex`, along best.n, into the answer for the shapes: in W and with their radii.
void set_answer(const Minkowski& c, const Pose& X_WA, const Simplex& simplex, const Best& best, Distance& out) {
  const double r_a = core_radius(c.a()), r_b = core_radius(c.b());
  Vector3d middle = 0.5 * (r_b - r_a) * best.n;
  for (int k = 0; k < simplex.n; ++k) middle += 0.5 * simplex.weight[k] * (simplex.corner[k].a + simplex.corner[k].b);
  out.phi = best.g - r_a - r_b;
  out.nhat_BA_W = X_WA.R * best.n;
  middle = X_WA * middle;
  out.p_WA = middle + 0.5 * out.phi * out.nhat_BA_W;
  out.p_WB = middle - 0.5 * out.phi * out.nhat_BA_W;
}

}  // namespace

void core_distance(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context,
                   Distance& out) {
  const Minkowski c(a, X_WA, b, X_WB);
  const bool curved = a.kind == Kind::Cylinder || b.kind == Kind::Cylinder;
  const double slack = kConsistent * c.size(), enough = context.limit + core_radius(a) + core_radius(b) + slack;
  Simplex simplex;
  Vector3d v;
  Best best;
  double bound = 0;  // upper bound of phi, from two points or from a polytope within C
  bool ends = true;
  if (find_nearest(c, (curved ? kCurvedGap : kTolerance) * c.size(), enough + slack, simplex, v)) {
    bound = v.norm();
    best.offer(c, v / bound);
    if (best.g >= enough) return set_answer(c, X_WA, simplex, best, out);
  } else {
    ends = find_way_out(c, (curved ? kCurvedDepth : kTolerance) * c.size(), simplex, v);
    bound = ends ? -v.dot(simplex.corner[0].w) : std::numeric_limits<double>::infinity();
    best.offer(c, -v);
  }
  if (!curved) refine(c, simplex, best);
  set_answer(c, X_WA, simplex, best, out);
  if (curved || !ends || !(std::abs(best.g - bound) <= slack)) polish(a, X_WA, b, X_WB, bound, out);
}

}  // namespace stiction::contact::detail
