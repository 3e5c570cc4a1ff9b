#include "stiction/cone/attempt.hpp"

#include <algorithm>
#include <cmath>

namespace stiction::cone::detail {
namespace {

constexpr double kToBoundary = 0.99;  // largest step as a part of the way to the boundary
constexpr double kBacktrack = 0.75;
constexpr double kNeighbourhood = 1e-3;  // smallest eigenvalue of the scaled point against its target
constexpr double kPlainStep = 0.5;       // a Newton step at least this long needs no corrector (Smoothed)
constexpr double kTooShort = 0.05;       // a predictor step below this from a centred point: raise μ
constexpr double kNear = 4;              // Exact: t this close to the centred end point takes plain Newton steps
constexpr double kCareful = 0.1;         // kNeighbourhood of the careful attempt
constexpr double kShort = 0.1;           // a corrected step below this is not worth taking: centre instead
constexpr double kBackUp = 10;           // factor by which μ is raised
constexpr double kShiftAhead = 0.8;      // part of the predictor step at which the corrector reads shifts; at the end they overshoot

}  // namespace

Spread Attempt::scale() {
  Spread spread;
  for_each_group([&]<int R>(Group<R>& group) { scale_group<R>(group, t_end_, spread); });
  if (s_.gives) {
    each_group(s_.bounds, [](Group<1>& group) {
      group.yield = group.give * group.v[0] * group.v[0];
      group.hold = 1.0 / (1.0 + group.yield);
    });
  }
  return spread;
}

/// H = Q + YᵀY and, while w ≠ Gx + g, p = V·r_p.
void Attempt::build() {
  TileFactor& h = s_.factor;
  const double* q = problem_.Q_tiles();
  int i = 0;
  for (const int from : s_.q_of) {
    double* t = h.tile(i++);
    if (from < 0) {
      for (int k = 0; k < 16; k += 4) store(t + k, V4{});
    } else {
      for (int k = 0; k < 16; k += 4) store(t + k, load(q + 16 * from + k));
    }
  }
  add_hessian(s_.cones, problem_.cones(), layout_, h);
  add_hessian(s_.lines, problem_.half_lines(), layout_, h);
  for (int g = 0; g < s_.bounds.groups; ++g) {
    double* t = h.tile(h.index(s_.bound_tile[at(g)], s_.bound_tile[at(g)]));
    const V4 y = s_.bounds.group[at(g)].v[0] * load(s_.bound_sign.data() + 4 * g);
    const V4 d = y * y * s_.bounds.group[at(g)].hold;
    for (int lane = 0; lane < kTile; ++lane) t[5 * lane] += d[lane];
  }
  if (primal_ == 0) return;
  for_each_group([&]<int R>(Group<R>& group) { scale_primal_residual<R>(group, primal_); });
}

/// out −= Qv
void Attempt::subtract_product(const double* v, double* out) const {
  const double* q = problem_.Q_tiles();
  for (const auto& tile : layout_.q_tiles()) {
    const double* y = v + 4 * tile.column;
    double* to = out + 4 * tile.row;
    store(to, load(to) - ((load(q) * y[0] + load(q + 4) * y[1]) + (load(q + 8) * y[2] + load(q + 12) * y[3])));
    if (tile.row != tile.column) {
      const V4 z = load(v + 4 * tile.row);
      double* other = out + 4 * tile.column;
      store(other, load(other) - sums(load(q) * z, load(q + 4) * z, load(q + 8) * z, load(q + 12) * z));
    }
    q += 16;
  }
}

/// gradient = −(Qx + b)
void Attempt::calc_gradient() {
  for (int t = 0; t < layout_.tiles(); ++t) store(s_.gradient.data() + 4 * t, -load(problem_.b_padded() + 4 * t));
  subtract_product(s_.x.data(), s_.gradient.data());
}

/// Factorises H and does the first half of solving for dx, which holds the right-hand side (kept in scale). If rounding makes a pivot
/// non-positive, H gets a slightly larger diagonal.
bool Attempt::factorise() {
  std::ranges::copy(s_.dx, s_.scale.begin());
  if (s_.factor.factorise(s_.dx.data())) return true;
  for (const double delta : {1e-15, 1e-13, 1e-11}) {
    build();
    for (int t = 0; t < layout_.tiles(); ++t) {
      double* d = s_.factor.tile(s_.factor.index(t, t));
      for (int lane = 0; lane < kTile; ++lane) d[5 * lane] *= 1 + delta;
    }
    std::ranges::copy(s_.scale, s_.dx.begin());
    if (s_.factor.factorise(s_.dx.data())) return true;
  }
  return false;
}

/// out += Yᵀa, `member` gives a of a group
template <class Member>
void Attempt::add_all_transposed(Member&& member, double* out) const {
  add_transposed(s_.cones, member, out);
  add_transposed(s_.lines, member, out);
  const Group<1>* group = s_.bounds.group.data();
  for (int g = 0; g < s_.bounds.groups; ++g, ++group) {
    double* to = out + 4 * s_.bound_tile[at(g)];
    store(to, load(to) + group->v[0] * load(s_.bound_sign.data() + 4 * g) * (member(*group)[0] * group->hold));
  }
}

/// Calls f(group, Y·dx of the group) for all groups.
template <class F>
void Attempt::for_each_product(const double* dx, F&& f) {
  for (int g = 0; g < s_.cones.groups; ++g) f(s_.cones.group[at(g)], multiply_group(s_.cones, g, dx));
  for (int g = 0; g < s_.lines.groups; ++g) f(s_.lines.group[at(g)], multiply_group(s_.lines, g, dx));
  Group<1>* group = s_.bounds.group.data();
  for (int g = 0; g < s_.bounds.groups; ++g, ++group) {
    f(*group, Element<1>{{group->v[0] * load(s_.bound_sign.data() + 4 * g) * load(dx + 4 * s_.bound_tile[at(g)])}});
  }
}

/// Improves dx by the residual of H·dx = rhs (rhs in s_.scale).
void Attempt::refine(double* dx) {
  double* residual = s_.scratch.data();
  for (int k = 0; k < 2; ++k) {
    std::ranges::copy(s_.scale, s_.scratch.begin());
    subtract_product(dx, residual);
    for_each_product(dx, [&]<int R>(Group<R>& group, Element<R> u) {
      for (auto& e : u.e) e = -e;
      store_element<R>(group.u, u);
    });
    add_all_transposed(
        [](const auto& group) -> const auto& { return group.u; }, residual);
    s_.factor.solve(residual);
    for (int i = 0; i < layout_.padded_size(); ++i) dx[i] += residual[i];
  }
}

/// Sets dx to the right-hand side of the Newton direction to t·weight·e, which removes the part `reduction` of both infeasibilities (less
/// than 1 only with t > 0). With `corrector` it includes Mehrotra's second-order term from the direction now in u, s.
void Attempt::set_rhs(double t, bool corrector, double reduction) {
  const bool has_p = primal_ != 0 && reduction > 0;
  const bool has_c = t != 0 || corrector;
  double* dx = s_.dx.data();
  for (int k = 0; k < layout_.padded_size(); k += 4) store(dx + k, load(s_.gradient.data() + k) * reduction);
  if (has_c) {
    for_each_group([&]<int R>(Group<R>& group) {
      if (corrector)
        centring_group<R, true>(group, t, second_order_);
      else
        centring_group<R, false>(group, t, 0);
      auto c = load_element<R>(group.c);
      if (has_p) {
        for (int r = 0; r < R; ++r) c.e[r] += reduction * group.p[r];
      }
      if (reduction < 1) {
        for (int r = 0; r < R; ++r) c.e[r] -= (1 - reduction) * group.lambda[r];
      }
      store_element<R>(group.u, c);  // u is free here: the right-hand side c + p
    });
  }
  if (has_c)
    add_all_transposed(
        [](const auto& group) -> const auto& { return group.u; }, dx);
  else if (has_p)
    add_all_transposed(
        [](const auto& group) -> const auto& { return group.p; }, dx);
  if (!s_.gives) return;
  for (int g = 0; g < s_.bounds.groups; ++g) {  // term of the soft bounds in Gᵀz, (20)
    const Group<1>& group = s_.bounds.group[at(g)];
    double* to = dx + 4 * s_.bound_tile[at(g)];
    store(to, load(to) + reduction * (group.v[0] * load(s_.bound_sign.data() + 4 * g) * group.hold * (group.yield * group.lambda[0])));
  }
}

/// Computes the rest of the direction from the solution dx of H·dx = rhs. @returns the largest step that stays inside all cones
double Attempt::finish_direction(double t, bool corrector, double reduction) {
  const bool has_p = primal_ != 0 && reduction > 0;
  const bool has_c = t != 0 || corrector;
  double* dx = s_.dx.data();
  if (careful_) refine(dx);
  V4 inverse = all(1e-30);
  for_each_product(
      dx, [&]<int R>(Group<R>& group, const Element<R>& u) { direction_group<R>(group, u, has_p ? reduction : 0.0, has_c, inverse); });
  return 1.0 / largest(inverse);
}

double Attempt::calc_direction(double t, bool corrector, double reduction) {
  set_rhs(t, corrector, reduction);
  if (careful_) std::ranges::copy(s_.dx, s_.scale.begin());
  s_.factor.solve(s_.dx.data());
  return finish_direction(t, corrector, reduction);
}

/// Shortens the step until it stays inside the neighbourhood of the central path around t.
double Attempt::shorten(double alpha, double t) {
  const double floor = (careful_ ? kCareful : kNeighbourhood) * t;
  for (int k = 0; k < 12; ++k, alpha *= kBacktrack) {
    V4 margin = all(1.0);
    for_each_group([&]<int R>(const Group<R>& group) { margin = min(margin, margin_group<R>(group, alpha, floor)); });
    if (largest(-margin) <= 0) break;
  }
  return alpha;
}

void Attempt::move(double alpha, double reduction) {
  for_each_group([&]<int R>(Group<R>& group) { move_group<R>(group, alpha); });
  for (int t = 0; t < layout_.tiles(); ++t) {
    store(s_.x.data() + 4 * t, load(s_.x.data() + 4 * t) + alpha * load(s_.dx.data() + 4 * t));
  }
  primal_ *= 1 - alpha * reduction;  // exactly 0 after a full step
  calc_gradient();
}

/// One predictor(–corrector) step. @returns false when no progress is possible
bool Attempt::step() {
  s_.factor.solve_backward(s_.dx.data());  // factorise() has begun this direction
  const double largest_affine = finish_direction(t_end_, false, 1.0);
  const double affine = std::min(1.0, kToBoundary * largest_affine);
  if (!(affine > 0)) return false;
  const bool plain = n_rows_ == 0 || (smoothed_ ? affine >= (careful_ ? 1.0 : kPlainStep) : t_ < kNear * t_end_);
  double alpha = affine, reduction = 1;
  bool centred = false;
  if (plain) {
    alpha = shorten(affine, t_end_);
  } else {
    if (following_) anticipate_tangents(kShiftAhead * affine);
    second_order_ = careful_ ? affine : 1;
    const double left = 1 - std::min(1.0, largest_affine);
    double t = t_end_ + left * std::sqrt(left) * (t_ - t_end_);  // exponent 1.5: measured best of 0.8 … 3
    alpha = std::min(1.0, kToBoundary * calc_direction(t, true, 1.0));
    alpha = shorten(alpha, t);
    if (alpha < std::max(0.5 * affine, kShort)) {
      // Centre. If even a centred point allows only short steps, μ is too small for the remaining infeasibility, so μ is raised.
      const bool up = centred_ && affine < kTooShort;
      const double centring = std::max(1 - affine, 0.5);
      t = up ? kBackUp * std::max(t_, t_end_) : t_end_ + centring * (t_ - t_end_);
      reduction = up ? 0.0 : 1 - centring;
      alpha = shorten(std::min(1.0, kToBoundary * calc_direction(t, false, reduction)), up ? t_ : t);  // the point has only t_
      centred = alpha > kPlainStep;
    }
  }
  if (!(alpha > 1e-10)) return false;
  centred_ = centred;
  move(alpha, reduction);
  return true;
}

}  // namespace stiction::cone::detail
