#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/sensing/residual.hpp"

namespace stiction::sensing {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kRounding = std::numeric_limits<double>::epsilon();

/// The objective with f_t in the principal axes of A_tt, which is diag(d) there.
struct Planar {
  double A_nn, a_n;
  Vector2d A_nt, a_t, d;
  Eigen::Matrix2d Q;  ///< f_t = Q t

  Planar(const Matrix3d& A, const Vector3d& a) : A_nn(A(0, 0)), a_n(a[0]) {
    const double half_angle = 0.5 * std::atan2(2 * A(1, 2), A(1, 1) - A(2, 2));
    const double c = std::cos(half_angle), s = std::sin(half_angle);
    Q << c, -s, s, c;
    const Eigen::Matrix2d D = Q.transpose() * A.bottomRightCorner<2, 2>() * Q;
    d = D.diagonal().cwiseMax(0);
    A_nt = Q.transpose() * A.block<2, 1>(1, 0);
    a_t = Q.transpose() * a.tail<2>();
  }
};

/// The best tangential force at f_k = s: (D + λ) t = b with b = a_t − s A_nt, ‖t‖ ≤ μ s, λ ≥ 0, λ (‖t‖ − μ s) = 0.
struct Tangential {
  Vector2d t;
  double lambda;
  double slope;      ///< h′(s)/2
  double curvature;  ///< h″(s)/2
};

Vector2d solve(const Vector2d& d, const Vector2d& b) {
  return {b[0] != 0 ? b[0] / d[0] : 0, b[1] != 0 ? b[1] / d[1] : 0};  // a component without gradient stays 0
}

Tangential calc_tangential(const Planar& P, double mu, double s) {
  const double radius = mu * s;
  const Vector2d b = P.a_t - s * P.A_nt;
  Tangential out{solve(P.d, b), 0, 0, 0};
  const bool inside = out.t.norm() <= radius;  // false for infinities
  if (!inside) {
    // 1/‖t(λ)‖ is concave: from the left of its root Newton's steps only grow towards it. Each component alone is a bound.
    double lambda = std::max({0.0, std::abs(b[0]) / radius - P.d[0], std::abs(b[1]) / radius - P.d[1]});
    constexpr int kMost = 50;
    for (int i = 0; i < kMost; ++i) {
      out.t = solve(P.d.array() + lambda, b);
      const double length = out.t.norm();
      const double descent = out.t.dot(solve(P.d.array() + lambda, out.t));
      const double step = length * length / descent * (length - radius) / radius;
      if (!(step > 2 * kRounding * lambda)) break;
      lambda += step;
    }
    out.lambda = lambda;
  }
  out.slope = P.A_nn * s + P.A_nt.dot(out.t) - P.a_n - out.lambda * mu * mu * s;
  const Vector2d M_A = solve(P.d.array() + out.lambda, P.A_nt);
  if (inside) {
    out.curvature = P.A_nn - P.A_nt.dot(M_A);
  } else {
    const Vector2d M_t = solve(P.d.array() + out.lambda, out.t);
    const double dlambda = -(mu * radius + out.t.dot(M_A)) / out.t.dot(M_t);
    out.curvature = P.A_nn - P.A_nt.dot(M_A + dlambda * M_t) - mu * (dlambda * radius + mu * out.lambda);
  }
  return out;
}

}  // namespace

Residual minimize_lorentz(const Matrix3d& A, const Vector3d& a, double mu) {
  Residual out;
  const double size = A.trace();
  // f = 0 where the objective falls nowhere in the cone: −a in the dual cone.
  if (!(size > 0) || a[0] + mu * a.tail<2>().norm() <= 0) return out;

  const Planar P(A, a);
  double low = 0, high = a.norm() / size;
  Tangential at = calc_tangential(P, mu, high);
  constexpr int kMostDoublings = 60;  // where A is singular the least value may lie at infinity, and is approached
  for (int i = 0; at.slope < 0 && i < kMostDoublings; ++i) {
    low = high;
    high *= 2;
    at = calc_tangential(P, mu, high);
  }
  double s = high;
  constexpr int kMost = 100;
  for (int i = 0; i < kMost && at.slope != 0; ++i) {
    (at.slope < 0 ? low : high) = s;
    double next = s - at.slope / at.curvature;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double moved = std::abs(next - s);
    s = next;
    at = calc_tangential(P, mu, s);
    if (moved <= 4 * kRounding * s) break;
  }
  out.force_C << s, P.Q * at.t;
  out.value = out.force_C.dot(A * out.force_C) - 2 * a.dot(out.force_C);
  out.face = at.lambda > 0 ? ConeFace::Facet : ConeFace::Interior;
  if (out.value >= 0) return Residual{};
  return out;
}

}  // namespace stiction::sensing
