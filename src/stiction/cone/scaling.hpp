#pragma once

#include "stiction/cone/simd.hpp"
#include "stiction/cone/state.hpp"

/// Jordan-algebra kernels on four rows at a time (docs/theory/cone.md, eq. 4–10). R = 3: L³; R = 1: half-line.
namespace stiction::cone::detail {

template <int R>
struct Element {
  V4 e[R];
};

template <int R>
inline Element<R> load_element(const V4 (&a)[R]) {
  Element<R> x;
  for (int r = 0; r < R; ++r) x.e[r] = a[r];
  return x;
}
template <int R>
inline void store_element(V4 (&a)[R], const Element<R>& x) {
  for (int r = 0; r < R; ++r) a[r] = x.e[r];
}

template <int R>
inline V4 dot(const Element<R>& a, const Element<R>& b) {
  if constexpr (R == 1)
    return a.e[0] * b.e[0];
  else
    return a.e[0] * b.e[0] + (a.e[1] * b.e[1] + a.e[2] * b.e[2]);
}
inline V4 det(const Element<3>& a) { return a.e[0] * a.e[0] - (a.e[1] * a.e[1] + a.e[2] * a.e[2]); }

/// V·x with V symmetric, entries 00 01 02 11 12 22; sign = −1 flips 01 and 02, which gives W/η² (eq. 6).
template <int Sign>
inline Element<3> apply(const V4* v, const Element<3>& x) {
  if constexpr (Sign > 0) {
    return {{v[0] * x.e[0] + (v[1] * x.e[1] + v[2] * x.e[2]), v[1] * x.e[0] + (v[3] * x.e[1] + v[4] * x.e[2]),
             v[2] * x.e[0] + (v[4] * x.e[1] + v[5] * x.e[2])}};
  } else {
    return {{v[0] * x.e[0] - (v[1] * x.e[1] + v[2] * x.e[2]), (v[3] * x.e[1] + v[4] * x.e[2]) - v[1] * x.e[0],
             (v[4] * x.e[1] + v[5] * x.e[2]) - v[2] * x.e[0]}};
  }
}

/// Relative accuracy of w∘z, as a part of w₀z₀.
inline constexpr double kRounding = 1e-14;

/// Position of the iterate with respect to the central path, over all rows seen so far.
struct Spread {
  V4 mean{};   // Σ wᵀz / weight
  V4 worst{};  // max wᵀz / work
  V4 off{};    // max ‖w∘z − t·weight·e‖∞ / weight
};

/// Computes the Nesterov–Todd scaling of a group: V, λ and the quantities derived from them (eq. 4–7).
template <int R>
inline void scale_group(Group<R>& b, double t, Spread& spread) {
  const auto w = load_element<R>(b.w);
  const auto z = load_element<R>(b.z);
  const V4 weight = b.weight;
  const V4 inv_weight = b.inv_weight;
  const V4 m = dot<R>(w, z);
  V4 off = abs(m - t * weight);
  if constexpr (R == 3) {
    for (int r = 1; r < 3; ++r) off = max(off, abs(w.e[0] * z.e[r] + z.e[0] * w.e[r]));
    const V4 det_w = det(w), det_z = det(z);
    const V4 sp = sqrt(det_w * det_z);
    const V4 isp = 1.0 / sp;
    const V4 r = det_w * isp, ir = det_z * isp;  // r = η²
    const V4 eta = sqrt(r);
    const V4 q = sqrt(2.0 * (sp + m));
    const V4 iq = 1.0 / q;
    const V4 p0 = (w.e[0] + r * z.e[0]) * iq, p1 = (w.e[1] - r * z.e[1]) * iq, p2 = (w.e[2] - r * z.e[2]) * iq;
    const V4 k = 1.0 / (p0 + eta);
    const V4 a = eta * ir, ki = k * ir;
    b.v[0] = p0 * ir, b.v[1] = -p1 * ir, b.v[2] = -p2 * ir;
    b.v[3] = a + p1 * p1 * ki, b.v[4] = p1 * p2 * ki, b.v[5] = a + p2 * p2 * ki;
    const V4 l0 = 0.5 * q;
    const V4 from_w = l0 + eta * z.e[0], from_z = eta * (eta * l0 + w.e[0]), scale = iq * k;
    store_element<R>(b.lambda, {{l0, (from_w * w.e[1] + from_z * z.e[1]) * scale, (from_w * w.e[2] + from_z * z.e[2]) * scale}});
    b.ratio = r;
    b.inv_det = isp;
    b.inv_lambda0 = 2.0 * iq;
  } else {
    const V4 l = sqrt(m);
    const V4 il = 1.0 / l;
    b.lambda[0] = l;
    b.inv_lambda0 = il;
    b.v[0] = z.e[0] * il;
    b.ratio = w.e[0] * il;
  }
  spread.mean += m * inv_weight;  // inv_weight is 0 at dead lanes
  spread.worst = max(spread.worst, m * b.inv_work);
  spread.off = max(spread.off, (off - kRounding * w.e[0] * z.e[0]) * inv_weight);
}

/// p = V·r_p·factor
template <int R>
inline void scale_primal_residual(Group<R>& b, double factor) {
  const auto r = load_element<R>(b.r_p);
  if constexpr (R == 3) {
    auto p = apply<1>(b.v, r);
    for (auto& e : p.e) e *= factor;
    store_element<R>(b.p, p);
  } else {
    b.p[0] = b.v[0] * r.e[0] * factor;
  }
}

/// λ∖r: the solution d of λ∘d = r.
template <int R>
inline Element<R> divide(const Group<R>& b, const Element<R>& lambda, const Element<R>& r) {
  const V4 il0 = b.inv_lambda0;
  if constexpr (R == 1) {
    return {{r.e[0] * il0}};
  } else {
    const V4 d0 = (lambda.e[0] * r.e[0] - (lambda.e[1] * r.e[1] + lambda.e[2] * r.e[2])) * b.inv_det;
    return {{d0, (r.e[1] - d0 * lambda.e[1]) * il0, (r.e[2] - d0 * lambda.e[2]) * il0}};
  }
}

/// c = λ∖(t·weight·e − second_order·u∘s), u∘s only when Corrector.
template <int R, bool Corrector>
inline void centring_group(Group<R>& b, double t, double second_order) {
  const auto lambda = load_element<R>(b.lambda);
  Element<R> r{};
  r.e[0] = t * b.weight;
  if constexpr (Corrector) {
    const auto u = load_element<R>(b.u);
    const auto s = load_element<R>(b.s);
    r.e[0] -= second_order * dot<R>(u, s);
    if constexpr (R == 3) {
      for (int k = 1; k < 3; ++k) r.e[k] = -second_order * (u.e[0] * s.e[k] + s.e[0] * u.e[k]);
    }
  }
  store_element<R>(b.c, divide<R>(b, lambda, r));
}

/// Largest 1/α over the group for which λ + αd leaves the cone (eq. 9); `il` = 1/det λ, or 1/λ for R = 1.
template <int R>
inline V4 inverse_step(const Element<R>& lambda, const Element<R>& d, V4 il, V4 det_lambda) {
  if constexpr (R == 1) {
    (void)det_lambda;
    (void)lambda;
    return -d.e[0] * il;
  } else {
    const V4 a = det(d);
    const V4 bb = lambda.e[0] * d.e[0] - (lambda.e[1] * d.e[1] + lambda.e[2] * d.e[2]);
    const V4 disc = max(bb * bb - a * det_lambda, V4{});
    return (sqrt(disc) - bb) * il;
  }
}

/// From u = Y·dx makes the scaled directions u ← u − p_part·p and s = c − λ − u; raises inverse_alpha.
template <int R>
inline void direction_group(Group<R>& b, Element<R> u, double p_part, bool has_c, V4& inverse_alpha) {
  const auto lambda = load_element<R>(b.lambda);
  const V4 live = b.live;
  if (p_part != 0) {
    const auto p = load_element<R>(b.p);
    for (int r = 0; r < R; ++r) u.e[r] -= p_part * p.e[r];
  }
  Element<R> s;
  for (int r = 0; r < R; ++r) s.e[r] = -lambda.e[r] - u.e[r];
  if (has_c) {
    const auto c = load_element<R>(b.c);
    for (int r = 0; r < R; ++r) s.e[r] += c.e[r];
  }
  for (int r = 0; r < R; ++r) s.e[r] *= live;
  if constexpr (R == 1) {  // (20)
    s.e[0] *= b.hold;
    u.e[0] += b.yield * s.e[0];
  }
  store_element<R>(b.u, u);
  store_element<R>(b.s, s);
  const V4 il = R == 3 ? b.inv_det : b.inv_lambda0;
  V4 det_lambda{};
  if constexpr (R == 3) det_lambda = det(lambda);
  inverse_alpha = max(inverse_alpha, max(inverse_step<R>(lambda, u, il, det_lambda), inverse_step<R>(lambda, s, il, det_lambda)));
}

/// Smallest of (μ_min − floor) in a form without roots: both eigenvalues of the scaled point at step α are ≥ floor·weight iff
/// the result is ≥ 0 (eq. 10).
template <int R>
inline V4 margin_group(const Group<R>& b, double alpha, double floor) {
  const auto lambda = load_element<R>(b.lambda);
  const auto u = load_element<R>(b.u);
  const auto s = load_element<R>(b.s);
  Element<R> x, y;
  for (int r = 0; r < R; ++r) {
    x.e[r] = lambda.e[r] + alpha * u.e[r];
    y.e[r] = lambda.e[r] + alpha * s.e[r];
  }
  const V4 m = dot<R>(x, y);
  const V4 tau = floor * b.weight;
  if constexpr (R == 1) {
    return m - tau;
  } else {
    const V4 dx = det(x), dy = det(y);
    return min(min(m - tau, (tau * tau - 2.0 * m * tau) + dx * dy), min(dx, dy));
  }
}

/// w += αWu, z += αVs
template <int R>
inline void move_group(Group<R>& b, double alpha) {
  auto w = load_element<R>(b.w);
  auto z = load_element<R>(b.z);
  const auto u = load_element<R>(b.u);
  const auto s = load_element<R>(b.s);
  if constexpr (R == 3) {
    const auto du = apply<-1>(b.v, u);
    const auto ds = apply<1>(b.v, s);
    const V4 r = b.ratio * alpha;
    for (int k = 0; k < 3; ++k) {
      w.e[k] += r * du.e[k];
      z.e[k] += alpha * ds.e[k];
    }
  } else {
    w.e[0] += alpha * b.ratio * u.e[0];
    z.e[0] += alpha * b.v[0] * s.e[0];
  }
  store_element<R>(b.w, w);
  store_element<R>(b.z, z);
}

}  // namespace stiction::cone::detail
