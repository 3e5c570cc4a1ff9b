// Two boxes by their fifteen separating axes. docs/theory/contact.md §9.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stiction/contact/patch.hpp"

namespace stiction::contact::detail {
namespace {

constexpr double kParallelEdges = 1e-4;  // sine of the angle below which two edges give no axis of their own
constexpr double kTie = 1e-13;           // rounding of a separation, of the sizes; an edge axis has to beat the faces by more

double sign(double x) { return x < 0 ? -1.0 : 1.0; }

/// Largest separation over the axes met so far; n points from B to A.
struct Best {
  double s = -1e300;
  int i = -1, j = -1;  // edges of A and B; −1, −1 for a face
  Vector3d n{0, 0, 1};
};

/// Nearest points of the edge of A along its axis i and the edge of B along its axis j, those farthest along ∓n. False if they lie beyond the
/// ends of the edges.
bool find_edge_points(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const Best& best, Distance& out) {
  const auto middle = [&](const ShapeData& s, const Pose& X, const Vector3d& d, int along) {
    const Vector3d l = X.R.transpose() * d;
    Vector3d p(sign(l.x()) * s.half.x(), sign(l.y()) * s.half.y(), sign(l.z()) * s.half.z());
    p[along] = 0;
    return Vector3d(X * p);
  };
  const Vector3d p = middle(a, X_WA, -best.n, best.i), q = middle(b, X_WB, best.n, best.j);
  const Vector3d u = X_WA.R.col(best.i), v = X_WB.R.col(best.j), r = p - q;
  const double uv = u.dot(v), sin2 = 1 - uv * uv;
  const double s = (uv * v.dot(r) - u.dot(r)) / sin2, t = (v.dot(r) - uv * u.dot(r)) / sin2;
  const double h_a = a.half[best.i], h_b = b.half[best.j];
  const Vector3d mean = 0.5 * (p + std::clamp(s, -h_a, h_a) * u + q + std::clamp(t, -h_b, h_b) * v);
  out.p_WA = mean + 0.5 * best.s * best.n;
  out.p_WB = mean - 0.5 * best.s * best.n;
  return std::abs(s) <= h_a && std::abs(t) <= h_b;
}

}  // namespace

bool box_box(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, double limit, Distance& out) {
  const Eigen::Matrix3d R = X_WA.R.transpose() * X_WB.R, Q = R.cwiseAbs();
  const Vector3d t_W = X_WA.p - X_WB.p;
  const Vector3d t = X_WA.R.transpose() * t_W, t_B = X_WB.R.transpose() * t_W;
  const double tie = kTie * (a.bounding_radius + b.bounding_radius);

  Best best;
  const Vector3d s_b = t_B.cwiseAbs() - b.half - Q.transpose() * a.half, s_a = t.cwiseAbs() - a.half - Q * b.half;
  for (int k = 0; k < 3; ++k) {
    if (s_b[k] > best.s + tie) best = {s_b[k], -1, -1, sign(t_B[k]) * X_WB.R.col(k)};
  }
  for (int k = 0; k < 3; ++k) {  // at a tie the face of B stays
    if (s_a[k] > best.s + 10 * tie) best = {s_a[k], -1, -1, sign(t[k]) * X_WA.R.col(k)};
  }
  for (int i = 0; i < 3 && best.s < limit; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const double sin2 = 1 - R(i, j) * R(i, j);
      if (sin2 < kParallelEdges * kParallelEdges) continue;
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double along = t[i2] * R(i1, j) - t[i1] * R(i2, j);
      const double reach = a.half[i1] * Q(i2, j) + a.half[i2] * Q(i1, j) + b.half[j1] * Q(i, j2) + b.half[j2] * Q(i, j1);
      const double length = std::sqrt(sin2), s = (std::abs(along) - reach) / length;
      if (s <= best.s + tie / length) continue;
      best = {s, i, j, sign(along) / length * X_WA.R.col(i).cross(X_WB.R.col(j))};
    }
  }
  out.phi = best.s;
  out.nhat_BA_W = best.n;
  if (best.i < 0) return false;
  const bool inside = find_edge_points(a, X_WA, b, X_WB, best, out);
  return inside || best.s < 0;
}

}  // namespace stiction::contact::detail
