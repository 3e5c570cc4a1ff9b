#include "stiction/contact/feature_pair.hpp"

#include <cmath>

namespace stiction::contact::detail {
namespace {

constexpr double kParallel = 1e-13;  // sine of the angle below which two edges count as parallel [-]; the relative error is of this size

// Rank-one curvature term of a rim, −∂p/∂d t tᵀ, in the second derivative of the separation.
double curvature(const Feature& f, const Vector3d& n, Vector3d& t) {
  if (f.rim <= 0) return 0.0;
  const Vector3d u = n - f.rim_axis * f.rim_axis.dot(n);
  const double length = u.norm();
  if (length < 1e-9) return 0.0;
  t = f.rim_axis.cross(u / length);
  return f.rim / length;
}

// Finds the normal by Newton's method, if it is not given by a face or by two edges.
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
    // If the gap is small compared with the rim, a full step overshoots: shorten the step until the separation grows.
    double length = std::min(1.0, 0.1 / std::max(size, 1e-300));
    Vector3d next;
    for (int halving = 0; halving < 20; ++halving, length *= 0.5) {
      next = (n + T * step * length).normalized();
      if (size < 1e-5 || next.dot(a.support(-next) - b.support(next)) >= g) break;  // near convergence rounding would decide this test
    }
    n = next;
    if (n.dot(start) < 0.95) return false;
    done = size < 1e-15;
  }
  return n.dot(start) > 0.95;
}

}  // namespace

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
    // The cross product of nearly parallel edges has few digits. If n is made perpendicular to one edge, its remaining error keeps it
    // perpendicular to both.
    n = (n - a.dir[0] * a.dir[0].dot(n)).normalized();
    n = (n - a.dir[0] * a.dir[0].dot(n)).normalized();
    n *= sign(n.dot(start));
  } else {
    return climb(a, b, n);
  }
  return n.dot(start) > 0.95;
}

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

namespace {

// A rim, edge or axis as a curve p(t).
struct Curve {
  const Feature& f;
  Vector3d e1{0, 0, 0}, e2{0, 0, 0};  // radius vectors of a rim at 0 and at a quarter turn
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
  double offset() const { return round ? 0.0 : f.rim; }  // distance of the surface from the curve
};

constexpr double kFlatRim = 0.2;  // sine of the angle between a normal and the axis below which a rim is seen as a circle

}  // namespace

bool is_flat_rim(const Feature& f, const Vector3d& n) { return f.n_dirs == 0 && f.rim > 0 && f.rim_axis.cross(n).norm() < kFlatRim; }

int find_starts(const Feature& rim, const Feature& other, const Vector3d& n, const Vector3d& towards, Vector3d out[2]) {
  Vector3d foot, along;  // line through both points, seen along n
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

bool find_crossing(const Feature& of_a, const Feature& of_b, const Vector3d& near, Vector3d& n, Vector3d& p_a, Vector3d& p_b) {
  const Vector3d start = n;
  Curve a(of_a), b(of_b);
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

}  // namespace stiction::contact::detail
