#pragma once

#include "stiction/sensing/four.hpp"
#include "stiction/sensing/friction_cone.hpp"

// The minimisation over a polyhedral cone: of four problems at a time, or of one with four rays and facets at a time. No branches on values.

namespace stiction::sensing::detail {

/// Symmetric 3 × 3, by rows.
template <class T>
struct Symmetric {
  T xx, xy, xz, yy, yz, zz;
};

template <class T>
struct Minimum {
  T gain;  ///< 2 aᵀ f − fᵀ A f ≥ 0
  T f[3];  ///< in the contact frame
  T face;  ///< −1 apex, i edge, n_d + i facet, 2 n_d interior
};

template <class T>
T splat(double x) {
  return x - T{};
}

/// A face is left out where the torques of its rays are so nearly dependent that rounding would decide. What that costs is of the
/// same size, because the cone of these torques is then as thin: its angle is the root of the determinant.
constexpr double kRounding = 1e-12;

template <class T, class Ray>
void dot_ray(const Symmetric<T>& A, const Ray* v, T out[3]) {
  out[0] = A.xx * v[0] + A.xy * v[1] + A.xz * v[2];
  out[1] = A.xy * v[0] + A.yy * v[1] + A.yz * v[2];
  out[2] = A.xz * v[0] + A.yz * v[1] + A.zz * v[2];
}

template <class Ray>
V4 dot(const V4* u, const Ray* v) {
  return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

/// Keeps (gain, f, face) where `better`.
template <class T, class Mask>
void keep(Mask better, T gain, T f0, T f1, T f2, T face, Minimum<T>& best) {
  best.gain = better ? gain : best.gain;
  best.f[0] = better ? f0 : best.f[0];
  best.f[1] = better ? f1 : best.f[1];
  best.f[2] = better ? f2 : best.f[2];
  best.face = better ? face : best.face;
}

/// f = A⁻¹ a where A is regular and f in the cone. LDLᵀ without pivots, which is backward stable for A ⪰ 0.
template <class T>
void try_interior(const Symmetric<T>& A, const T a[3], const FrictionCone& cone, T smallest, Minimum<T>& best) {
  const T d0 = A.xx, l10 = A.xy / d0, l20 = A.xz / d0;
  const T d1 = A.yy - l10 * A.xy, e = A.yz - l20 * A.xy, l21 = e / d1;
  const T d2 = A.zz - l20 * A.xz - l21 * e;
  const T y1 = a[1] - l10 * a[0], y2 = a[2] - l20 * a[0] - l21 * y1;
  const T f2 = y2 / d2, f1 = y1 / d1 - l21 * f2, f0 = a[0] / d0 - l10 * f1 - l20 * f2;
  auto good = (d0 > smallest) & (d1 > smallest) & (d2 > smallest);
  for (Eigen::Index i = 0; i < cone.facet_normals().cols(); ++i) {
    const double* m = &cone.facet_normals()(0, i);
    good = good & (m[0] * f0 + m[1] * f1 + m[2] * f2 >= T{});
  }
  const T linear = a[0] * f0 + a[1] * f1 + a[2] * f2;
  const T square = f0 * (A.xx * f0 + 2 * (A.xy * f1 + A.xz * f2)) + f1 * (A.yy * f1 + 2 * A.yz * f2) + A.zz * f2 * f2;
  const T gain = 2 * linear - square;
  keep(good & (gain > best.gain), gain, f0, f1, f2, splat<T>(2.0 * cone.rays()), best);
}

/// Four problems.
inline Minimum<V4> minimize(const Symmetric<V4>& A, const V4 a[3], const FrictionCone& cone) {
  using T = V4;
  const T zero{};
  Minimum<T> best{zero, {zero, zero, zero}, splat<T>(-1)};
  const T smallest = kRounding * (A.xx + A.yy + A.zz);
  const int n = cone.rays();
  const Eigen::Matrix3Xd& V = cone.ray_matrix();
  // Edge i: f = x v_i with x = c_i / q_ii. Facet (i, j): the 2 × 2 system of q_ii, q_ij, q_jj and c_i, c_j.
  T Av[3];
  dot_ray(A, &V(0, n - 1), Av);
  T q_i = V(0, n - 1) * Av[0] + V(1, n - 1) * Av[1] + V(2, n - 1) * Av[2];
  T c_i = V(0, n - 1) * a[0] + V(1, n - 1) * a[1] + V(2, n - 1) * a[2];
  for (int j = 0, i = n - 1; j < n; i = j++) {
    const double *v = &V(0, j), *u = &V(0, i);
    const T q_ij = v[0] * Av[0] + v[1] * Av[1] + v[2] * Av[2];
    dot_ray(A, v, Av);
    const T q_j = v[0] * Av[0] + v[1] * Av[1] + v[2] * Av[2];
    const T c_j = v[0] * a[0] + v[1] * a[1] + v[2] * a[2];
    const T x = c_j / q_j;
    keep((q_j > smallest) & (c_j > zero) & (c_j * x > best.gain), T(c_j * x), T(x * v[0]), T(x * v[1]), T(x * v[2]), splat<T>(j), best);
    const T det = q_i * q_j - q_ij * q_ij;
    const T x_i = (q_j * c_i - q_ij * c_j) / det, x_j = (q_i * c_j - q_ij * c_i) / det;
    const T gain = 2 * (c_i * x_i + c_j * x_j) - (x_i * (q_i * x_i + 2 * q_ij * x_j) + x_j * x_j * q_j);
    keep((det > kRounding * q_i * q_j) & (x_i >= zero) & (x_j >= zero) & (gain > best.gain), gain, T(x_i * u[0] + x_j * v[0]),
         T(x_i * u[1] + x_j * v[1]), T(x_i * u[2] + x_j * v[2]), splat<T>(n + i), best);
    q_i = q_j;
    c_i = c_j;
  }
  if (cone.facet_normals().cols() > 0) try_interior(A, a, cone, smallest, best);
  return best;
}

/// One problem: the edge of each ray and the facet to the next one, four at a time.
inline Minimum<double> minimize(const Symmetric<double>& A, const double a[3], const FrictionCone& cone) {
  const V4 zero{};
  Minimum<V4> lanes;  // filled one by one: in braces the compiler clears it through memory
  lanes.gain = lanes.f[0] = lanes.f[1] = lanes.f[2] = zero;
  lanes.face = splat<V4>(-1);
  const double smallest = kRounding * (A.xx + A.yy + A.zz);
  const Symmetric<V4> A4{splat<V4>(A.xx), splat<V4>(A.xy), splat<V4>(A.xz), splat<V4>(A.yy), splat<V4>(A.yz), splat<V4>(A.zz)};
  const int n = cone.rays();
  for (Eigen::Index first = 0; first < n; first += 4) {
    const auto row = [&](int r) { return load(&cone.facet_rays()(r, first)); };
    const V4 u[3] = {row(0), row(1), row(2)}, v[3] = {row(3), row(4), row(5)}, index = V4{0, 1, 2, 3} + static_cast<double>(first);
    V4 Au[3], Av[3];
    dot_ray(A4, u, Au);
    dot_ray(A4, v, Av);
    const V4 q_i = dot(u, Au), q_ij = dot(v, Au), q_j = dot(v, Av), c_i = dot(u, a), c_j = dot(v, a);
    const V4 x = c_i / q_i;
    keep((q_i > smallest) & (c_i > zero) & (c_i * x > lanes.gain), V4(c_i * x), V4(x * u[0]), V4(x * u[1]), V4(x * u[2]), index, lanes);
    const V4 det = q_i * q_j - q_ij * q_ij;
    const V4 x_i = (q_j * c_i - q_ij * c_j) / det, x_j = (q_i * c_j - q_ij * c_i) / det;
    const V4 gain = 2 * (c_i * x_i + c_j * x_j) - (x_i * (q_i * x_i + 2 * q_ij * x_j) + x_j * x_j * q_j);
    keep((det > kRounding * q_i * q_j) & (x_i >= zero) & (x_j >= zero) & (gain > lanes.gain), gain, V4(x_i * u[0] + x_j * v[0]),
         V4(x_i * u[1] + x_j * v[1]), V4(x_i * u[2] + x_j * v[2]), V4(n + index), lanes);
  }
  int lane = 0;
  for (int k = 1; k < 4; ++k) lane = lanes.gain[k] > lanes.gain[lane] ? k : lane;
  Minimum<double> best{lanes.gain[lane], {lanes.f[0][lane], lanes.f[1][lane], lanes.f[2][lane]}, lanes.face[lane]};
  if (cone.facet_normals().cols() > 0) try_interior(A, a, cone, smallest, best);
  return best;
}

}  // namespace stiction::sensing::detail
