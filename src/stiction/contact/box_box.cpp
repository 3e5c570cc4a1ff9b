// Two boxes: fifteen separating axes, the overlap of two faces, and the corners. docs/theory/contact.md §5, §9.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "stiction/contact/closed_form.hpp"
#include "stiction/contact/patch.hpp"

namespace stiction::contact::detail {
namespace {

// Sine of the angle below which two edges give no axis. The relative error from leaving the axis out is of this size.
constexpr double kParallelEdges = 1e-13;
constexpr double kTie = 1e-13;   // rounding error of a separation, as a share of the sizes; an edge axis must exceed the face axes by more
constexpr double kSame = 1e-12;  // distances that differ by less count as equal, as a share of the sizes
constexpr double kShort = 1e-7;  // a shorter vector between two points has too few digits to give a normal, as a share of the sizes

/// Largest separation over the axes tested so far; n points from B to A.
struct Best {
  double s = -1e300;
  int i = -1, j = -1;  // axes of the edges of A and B; for a face axis one of the two is −1
  Vector3d n{0, 0, 1};
  bool is_edge() const { return i >= 0 && j >= 0; }
};

/// Mean of the pairs of nearest points found so far; the mean is a pair of nearest points too.
struct Mean {
  Vector3d a{0, 0, 0}, b{0, 0, 0};
  int n = 0;
  void add(const Vector3d& p_a, const Vector3d& p_b) {
    a += p_a;
    b += p_b;
    ++n;
  }
};

void set_points(const Vector3d& middle, Distance& out) {
  out.p_WA = middle + 0.5 * out.phi * out.nhat_BA_W;
  out.p_WB = middle - 0.5 * out.phi * out.nhat_BA_W;
}

/// Sets the distance, the normal and the nearest points of two edges: the edge of A along its axis i that is farthest along −n, and the
/// edge of B along its axis j that is farthest along n. @returns false if the points lie beyond the ends of the edges
bool find_edge_points(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const Best& best, Distance& out) {
  const auto middle = [&](const ShapeData& s, const Pose& X, const Vector3d& d, int along) {
    const Vector3d l = X.R.transpose() * d;
    Vector3d p(sign(l.x()) * s.half.x(), sign(l.y()) * s.half.y(), sign(l.z()) * s.half.z());
    p[along] = 0;
    return Vector3d(X * p);
  };
  const Vector3d p = middle(a, X_WA, -best.n, best.i), q = middle(b, X_WB, best.n, best.j);
  const Vector3d u = X_WA.R.col(best.i), v = X_WB.R.col(best.j), r = p - q;
  const Vector3d across = best.n.cross(u);  // accurate where the edges are nearly parallel
  const double t = across.dot(r) / across.dot(v), s = u.dot(t * v - r);
  const double h_a = a.half[best.i], h_b = b.half[best.j];
  out.phi = best.s;
  out.nhat_BA_W = best.n;
  set_points(0.5 * (p + std::clamp(s, -h_a, h_a) * u + q + std::clamp(t, -h_b, h_b) * v), out);
  return std::abs(s) <= h_a && std::abs(t) <= h_b;
}

/// Tests the axes perpendicular to an edge of each box. The cross product has a rounding error that is divided by the sine of a small
/// angle. By construction this error is only equivalent to a turn of B by a few rounding errors.
void try_edges(const ShapeData& a, const Eigen::Matrix3d& R_WA, const ShapeData& b, const Eigen::Matrix3d& R_AB, const Vector3d& t,
               double limit, double tie, Best& best) {
  for (int i = 0; i < 3 && best.s < limit; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const double x = -R_AB(i2, j), y = R_AB(i1, j), sin2 = x * x + y * y;
      if (sin2 < kParallelEdges * kParallelEdges) continue;
      const double inverse = 1 / std::sqrt(sin2), x1 = x * inverse, y1 = y * inverse;  // n in A, along its axes i1 and i2
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double along = t[i1] * x1 + t[i2] * y1;
      const double reach = a.half[i1] * std::abs(x1) + a.half[i2] * std::abs(y1) +
                           b.half[j1] * std::abs(R_AB(i1, j1) * x1 + R_AB(i2, j1) * y1) +
                           b.half[j2] * std::abs(R_AB(i1, j2) * x1 + R_AB(i2, j2) * y1);
      const double s = std::abs(along) - reach;
      if (s <= best.s + tie) continue;
      best = {s, i, j, sign(along) * (x1 * R_WA.col(i1) + y1 * R_WA.col(i2))};
    }
  }
}

/// Sets the distance and the normal. @returns true if the axis is that of two edges and they attain it in the points of `out`, or overlap
bool find_axis(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, double limit, Best& best, Distance& out) {
  const Eigen::Matrix3d R = X_WA.R.transpose() * X_WB.R, Q = R.cwiseAbs();
  const Vector3d t_W = X_WA.p - X_WB.p;
  const Vector3d t = X_WA.R.transpose() * t_W, t_B = X_WB.R.transpose() * t_W;
  const double scale = a.bounding_radius + b.bounding_radius, tie = kTie * scale;
  const Vector3d s_b = t_B.cwiseAbs() - b.half - Q.transpose() * a.half, s_a = t.cwiseAbs() - a.half - Q * b.half;
  for (int k = 0; k < 3; ++k) {
    if (s_b[k] > best.s + tie) best = {s_b[k], -1, k, sign(t_B[k]) * X_WB.R.col(k)};
  }
  for (int k = 0; k < 3; ++k) {  // at a tie the face of B is kept
    if (s_a[k] > best.s + 10 * tie) best = {s_a[k], k, -1, sign(t[k]) * X_WA.R.col(k)};
  }
  const Best face = best;
  try_edges(a, X_WA.R, b, R, t, limit, tie, best);
  const bool attained = best.is_edge() && find_edge_points(a, X_WA, b, X_WB, best, out);
  // Edges that nearly lie in a face have the same separation as the face, and rounding decides which of the parallel edges is the farthest.
  if (!attained && best.s <= face.s + kSame * scale) best = face;
  out.phi = best.s;
  out.nhat_BA_W = best.n;
  return attained || (best.is_edge() && best.s < 0);
}

struct Corners {
  std::array<Vector3d, 8> at;  // x, y in the reference face, z over it
  int n = 0;
};

/// The part of the polygon with side · (±axis) ≤ half.
void clip(Corners& polygon, int axis, double side, double half) {
  Corners out;
  for (int k = 0; k < polygon.n; ++k) {
    const Vector3d &p = polygon.at[k], &q = polygon.at[(k + 1) % polygon.n];
    const double d_p = side * p[axis] - half, d_q = side * q[axis] - half;
    if (d_p <= 0) out.at[out.n++] = p;
    if ((d_p <= 0) != (d_q <= 0)) out.at[out.n++] = p + d_p / (d_p - d_q) * (q - p);
    if (out.n == static_cast<int>(out.at.size())) break;
  }
  polygon = out;
}

/// Clips the lowest face of the other box I to the part over face k of box R (outward normal m). `out` is the mean of the lowest corners of
/// this part. @returns false if no corner is as low as the height s
bool find_face_points(const ShapeData& r, const Pose& X_WR, const ShapeData& i, const Pose& X_WI, int k, const Vector3d& m, double s,
                      double tolerance, Vector3d& out) {
  const Vector3d down = X_WI.R.transpose() * -m;
  int face = 0;
  down.cwiseAbs().maxCoeff(&face);
  const int u = (face + 1) % 3, v = (face + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
  Corners polygon{.at = {}, .n = 4};
  for (int c = 0; c < 4; ++c) {
    Vector3d p;
    p[face] = sign(down[face]) * i.half[face];
    p[u] = c == 0 || c == 3 ? -i.half[u] : i.half[u];
    p[v] = c < 2 ? -i.half[v] : i.half[v];
    const Vector3d d = X_WI * p - X_WR.p;
    polygon.at[c] = {X_WR.R.col(k1).dot(d), X_WR.R.col(k2).dot(d), m.dot(d) - r.half[k]};
  }
  for (const double side : {-1.0, 1.0}) {
    clip(polygon, 0, side, r.half[k1]);
    clip(polygon, 1, side, r.half[k2]);
  }
  Vector3d sum(0, 0, 0);
  int n = 0;
  for (int c = 0; c < polygon.n; ++c) {
    if (polygon.at[c].z() > s + tolerance) continue;
    sum += polygon.at[c];
    ++n;
  }
  if (n == 0) return false;
  sum /= n;
  out = X_WR.p + sum.x() * X_WR.R.col(k1) + sum.y() * X_WR.R.col(k2) + (r.half[k] + 0.5 * s) * m;
  return true;
}

/// Nearest points of which one is a corner of a box; the mean if there are several such pairs.
double find_corner_points(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, double tolerance, Mean& mean) {
  std::array<double, 16> distance;
  std::array<Vector3d, 16> corner, nearest;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 16; ++k) {
    const bool of_a = k < 8;
    const ShapeData &self = of_a ? a : b, &other = of_a ? b : a;
    const Pose &X_self = of_a ? X_WA : X_WB, &X_other = of_a ? X_WB : X_WA;
    const Vector3d& h = self.half;
    corner[k] = X_self * Vector3d(k & 1 ? h.x() : -h.x(), k & 2 ? h.y() : -h.y(), k & 4 ? h.z() : -h.z());
    const Vector3d l = X_other.R.transpose() * (corner[k] - X_other.p);
    const Vector3d inside = l.cwiseMin(other.half).cwiseMax(-other.half);
    distance[k] = (l - inside).norm();
    nearest[k] = X_other * inside;
    least = std::min(least, distance[k]);
  }
  for (int k = 0; k < 16; ++k) {
    if (distance[k] <= least + tolerance) mean.add(k < 8 ? corner[k] : nearest[k], k < 8 ? nearest[k] : corner[k]);
  }
  mean.a /= mean.n;
  mean.b /= mean.n;
  return least;
}

}  // namespace

bool box_box(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, double limit, Distance& out) {
  Best best;
  return find_axis(a, X_WA, b, X_WB, limit, best, out);
}

void box_box_kernel(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext&, Distance& out) {
  const double scale = a.bounding_radius + b.bounding_radius, tolerance = kSame * scale;
  Best best;
  if (find_axis(a, X_WA, b, X_WB, std::numeric_limits<double>::infinity(), best, out)) return;
  if (!best.is_edge()) {
    Vector3d middle;
    const bool attained = best.i < 0 ? find_face_points(b, X_WB, a, X_WA, best.j, best.n, best.s, tolerance, middle)
                                     : find_face_points(a, X_WA, b, X_WB, best.i, -best.n, best.s, tolerance, middle);
    if (attained) {
      set_points(middle, out);
      return;
    }
  }
  // Nearest points inside two edges, or of a face and a corner, were handled above. In the remaining case a corner is among the nearest
  // points.
  Mean mean;
  const double least = find_corner_points(a, X_WA, b, X_WB, kTie * scale, mean);
  if (best.s > -tolerance && (least > kShort * scale || least > best.s + tolerance)) {
    out.phi = (mean.a - mean.b).norm();
    out.nhat_BA_W = (mean.a - mean.b) / out.phi;
  }
  set_points(0.5 * (mean.a + mean.b), out);
}

}  // namespace stiction::contact::detail
