#include "stiction/sensing/residual.hpp"

#include <algorithm>

#include "stiction/sensing/polyhedral.hpp"

namespace stiction::sensing {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Residual minimize_polyhedral(const Matrix3d& A, const Vector3d& a, const FrictionCone& cone) {
  const detail::Symmetric<double> entries{A(0, 0), A(0, 1), A(0, 2), A(1, 1), A(1, 2), A(2, 2)};
  const detail::Minimum<double> best = detail::minimize(entries, a.data(), cone);
  Residual out;
  out.value = -best.gain;
  out.force_C = Vector3d(best.f[0], best.f[1], best.f[2]);
  const int face = static_cast<int>(best.face), n = cone.rays();
  out.face = face < 0 ? ConeFace::Apex : face < n ? ConeFace::Edge : face < 2 * n ? ConeFace::Facet : ConeFace::Interior;
  out.ray = out.face == ConeFace::Edge || out.face == ConeFace::Facet ? face % n : -1;
  return out;
}

namespace {

using detail::V4;

/// A column of LinkTorque::kSize rows.
struct Column {
  V4 upper, lower;
  explicit Column(const double* p) : upper(detail::load(p)), lower(detail::load(p + 4)) {}
  Column(const V4& u, const V4& l) : upper(u), lower(l) {}
  friend Column operator+(const Column& a, const Column& b) { return {a.upper + b.upper, a.lower + b.lower}; }
  friend Column operator-(const Column& a, const Column& b) { return {a.upper - b.upper, a.lower - b.lower}; }
  friend Column operator*(double x, const Column& a) { return {x * a.upper, x * a.lower}; }
  friend double dot(const Column& a, const Column& b) {
    const V4 products = a.upper * b.upper + a.lower * b.lower;
    return (products[0] + products[2]) + (products[1] + products[3]);
  }
};

/// J_Cᵀ e (Y.1), up to an orthogonal factor.
inline Column map_force(const LinkTorque& link, const Vector3d& p, const Vector3d& e) {
  const Vector3d m = p.cross(e);
  const auto times = [](const auto& R, const Vector3d& x) {
    return x[0] * Column(R.col(0).data()) + x[1] * Column(R.col(1).data()) + x[2] * Column(R.col(2).data());
  };
  return times(link.R_w, m) + times(link.R_v, e);
}

}  // namespace

Residual calc_residual(const LinkTorque& link, const Vector3d& p_L, const Matrix3d& R_LC, const FrictionCone& cone) {
  static_assert(LinkTorque::kSize == 8);
  const Column M[3] = {map_force(link, p_L, R_LC.col(0)), map_force(link, p_L, R_LC.col(1)), map_force(link, p_L, R_LC.col(2))};
  const Column tau(link.R_tau.data());
  Matrix3d A;
  Vector3d a;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) A(i, j) = A(j, i) = dot(M[i], M[j]);
    A(i, i) += link.prior;
    a[i] = dot(M[i], tau);
  }
  Residual out = cone.is_lorentz() ? minimize_lorentz(A, a, cone.friction()) : minimize_polyhedral(A, a, cone);
  const Vector3d& f = out.force_C;
  const Column left = f[0] * M[0] + f[1] * M[1] + f[2] * M[2] - tau;
  out.value = dot(left, left) + link.prior * f.squaredNorm();  // no cancellation, however large the force
  return out;
}

void SampleBatch::resize(Index samples) {
  size = samples;
  rows.setZero(12, (samples + 3) / 4 * 4);
}

void SampleBatch::set(Index i, const Vector3d& p_L, const Matrix3d& R_LC) {
  rows.col(i) << p_L, R_LC.col(0), R_LC.col(1), R_LC.col(2);
  if (i == size - 1)
    for (Index pad = size; pad < rows.cols(); ++pad) rows.col(pad) = rows.col(i);
}

Matrix3d SampleBatch::R_LC(Index i) const {
  Matrix3d R;
  R << rows.col(i).segment<3>(3), rows.col(i).segment<3>(6), rows.col(i).segment<3>(9);
  return R;
}

namespace {

struct Vector3V {
  V4 x, y, z;
};
V4 dot(const Vector3V& a, const Vector3V& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector3V cross(const Vector3V& a, const Vector3V& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
Vector3V times(const Matrix3d& M, const Vector3V& a) {
  return {M(0, 0) * a.x + M(0, 1) * a.y + M(0, 2) * a.z, M(1, 0) * a.x + M(1, 1) * a.y + M(1, 2) * a.z,
          M(2, 0) * a.x + M(2, 1) * a.y + M(2, 2) * a.z};
}
Vector3V splat(const Vector3d& a) { return {detail::splat<V4>(a.x()), detail::splat<V4>(a.y()), detail::splat<V4>(a.z())}; }
/// A_C and a_C (Y.2) of four samples: with m = p × e for each axis e of the contact frame, e_iᵀ A e_j is the product of the torques (Y.1)
/// of unit forces along e_i and e_j.
void project(const LinkTorque& link, const Matrix3d& vw, const Vector3V& p, const Vector3V e[3], detail::Symmetric<V4>& A, V4 a[3]) {
  Vector3V m[3], wr[3], vr[3];
  const Vector3V w_tau = splat(link.w_tau), v_tau = splat(link.v_tau);
  for (int i = 0; i < 3; ++i) {
    m[i] = cross(p, e[i]);
    const Vector3V ww = times(link.ww, m[i]), wv = times(link.wv, e[i]), vw_m = times(vw, m[i]), vv = times(link.vv, e[i]);
    wr[i] = {ww.x + wv.x, ww.y + wv.y, ww.z + wv.z};
    vr[i] = {vw_m.x + vv.x, vw_m.y + vv.y, vw_m.z + vv.z};
    a[i] = dot(m[i], w_tau) + dot(e[i], v_tau);
  }
  A = {dot(m[0], wr[0]) + dot(e[0], vr[0]), dot(m[0], wr[1]) + dot(e[0], vr[1]), dot(m[0], wr[2]) + dot(e[0], vr[2]),
       dot(m[1], wr[1]) + dot(e[1], vr[1]), dot(m[1], wr[2]) + dot(e[1], vr[2]), dot(m[2], wr[2]) + dot(e[2], vr[2])};
  A.xx += link.prior;
  A.yy += link.prior;
  A.zz += link.prior;
}

}  // namespace

void calc_residuals(const LinkTorque& link, const SampleBatch& batch, const FrictionCone& cone, Eigen::Ref<Eigen::VectorXd> out) {
  if (cone.is_lorentz()) {
    for (Index i = 0; i < batch.rows.cols(); ++i) out[i] = calc_residual(link, batch.p_L(i), batch.R_LC(i), cone).value;
    return;
  }
  const Matrix3d vw = link.wv.transpose();
  const V4 zero{};
  for (Index i = 0; i < batch.rows.cols(); i += 4) {
    const auto row = [&](int r) { return detail::load(&batch.rows(r, i)); };
    const Vector3V p{row(0), row(1), row(2)};
    const Vector3V e[3] = {{row(3), row(4), row(5)}, {row(6), row(7), row(8)}, {row(9), row(10), row(11)}};
    detail::Symmetric<V4> A;
    V4 a[3];
    project(link, vw, p, e, A, a);
    const V4 left = link.tau_tau - detail::minimize(A, a, cone).gain;
    const V4 value = left > zero ? left : zero;
    detail::store(value, &out[i]);
  }
}

}  // namespace stiction::sensing
