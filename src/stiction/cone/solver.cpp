#include "stiction/cone/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "stiction/cone/rows.hpp"
#include "stiction/cone/scaling.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::cone {
namespace detail {
namespace {

using core::Status;

// Start of a cold attempt (docs/theory/cone.md §4).
constexpr double kColdCentre = 0.003;      // w∘z = θ·S·kColdCentre·e
constexpr double kColdSlack = 3e-3;        // smallest slack of w
constexpr double kWarmSlack = 1e-4;        // the same for a warm attempt
constexpr double kFarSlack = 1.0;          // slack of the retry
constexpr double kWarmMemory = 1e-5;       // z is remembered where the mean of wᵀz/θ passes this
// Steps.
constexpr double kToBoundary = 0.99;       // part of the way to the boundary
constexpr double kBacktrack = 0.75;
constexpr double kNeighbourhood = 1e-3;    // smallest eigenvalue of the scaled point against its target
constexpr double kPlainStep = 0.5;         // a Newton step at least this long needs no corrector (Smoothed)
constexpr double kTooShort = 0.05;         // a predictor step below this from a centred point: raise μ
constexpr double kNear = 4;                // Exact: t this close to the centred end point takes plain Newton steps
constexpr double kNoInterior = 1e-6;       // [unit of w]
constexpr double kCareful = 0.1;           // the neighbourhood of the careful attempt
constexpr double kShort = 0.1;             // a corrected step below this is not worth taking: centre instead
constexpr double kBackUp = 10;             // by this
constexpr double kCentreTolerance = 1e-7;  // relative, of the centred end point in Exact mode
constexpr double kExactEnd = 0.05;         // that point is at this part of the tolerance

std::size_t at(int i) { return static_cast<std::size_t>(i); }

class Attempt {
 public:
  Attempt(const Problem& problem, const Options& options, State& s)
      : problem_(problem), options_(options), s_(s), layout_(*s.layout), smoothed_(options.mode == Mode::Smoothed),
        n_rows_(problem.n_cones() + problem.n_half_lines() + problem.n_bounds()) {
    for (int i = 0; i < layout_.padded_size(); ++i) impulse_ = std::max(impulse_, std::abs(problem.b_padded()[i]));
    impulse_ = std::exp2(std::floor(std::log2(impulse_)));   // constant in b almost everywhere, as derivatives need
  }

  /// @param careful  refine every direction (slower)
  void start_cold(double least_slack, bool careful);
  bool try_start_warm();
  Status run(int& iterations);
  void leave_factor();
  const Residuals& residuals() const { return residuals_; }
  bool infeasible_proved() const { return infeasible_; }

 private:
  template <class F>
  void for_each_bank(F&& f) {
    f(s_.cones);
    f(s_.lines);
    f(s_.bounds);
  }
  Spread scale();
  void build();
  void calc_gradient();
  void subtract_product(const double* v, double* out) const;
  bool factorise();
  void add_all_transposed(const AlignedVector& cones, const AlignedVector& lines, const AlignedVector& bounds, double* out) const;
  template <class F>
  void for_each_product(const double* dx, F&& f);
  void refine(double* dx);
  double calc_direction(double t, bool corrector, double reduction);
  double shorten(double alpha, double t) const;
  void move(double alpha, double reduction);
  bool measure();
  bool prove_infeasible();
  bool step();
  void remember_z();

  const Problem& problem_;
  const Options& options_;
  State& s_;
  const Layout& layout_;
  bool smoothed_;
  int n_rows_;
  double t_ = 0;          // where the iterate is: mean of wᵀz / weight
  double t_end_ = 0;      // where it should go
  double impulse_ = 1;    // S = max(1, ‖b‖∞) rounded down to a power of 2: the unit of z, by which complementarity is measured in Exact mode
  double primal_ = 0;     // r_p = primal_ · (stored r_p)
  Residuals residuals_;
  bool infeasible_ = false;
  bool careful_ = false;
  bool centred_ = false;  // the last step was a centring step of good length
};

/// Calls f(kind, i, place, w pointer, z pointer) … with stride 4 between components.
template <int R, class F>
void for_each_row(Bank<R>& b, F&& f) {
  for (int i = 0; i < b.n; ++i) {
    const int base = (i / 4) * 4 * R + i % 4;
    f(i, base);
  }
}

template <int R>
double slack_of(const double* w, int stride) {
  if constexpr (R == 1) return w[0];
  else return w[0] - std::hypot(w[stride], w[2 * stride]);
}

/// z = value·w⁻¹ (Jordan inverse)
template <int R>
void set_inverse(double* z, const double* w, double value) {
  if constexpr (R == 1) {
    z[0] = value / w[0];
  } else {
    const double f = value / ((w[0] - std::hypot(w[4], w[8])) * (w[0] + std::hypot(w[4], w[8])));
    z[0] = f * w[0];
    z[4] = -f * w[4];
    z[8] = -f * w[8];
  }
}

template <int R>
void idle_lanes(Bank<R>& b) {
  for (int i = b.n; i < 4 * b.groups; ++i) {
    const int base = (i / 4) * 4 * R + i % 4;
    for (int r = 0; r < R; ++r) {
      const double e = r == 0 ? 1.0 : 0.0;
      b.w[at(base + 4 * r)] = b.z[at(base + 4 * r)] = e;
      b.r_p[at(base + 4 * r)] = b.u[at(base + 4 * r)] = 0.0;
    }
    b.weight[at(i)] = b.inv_weight[at(i)] = b.live[at(i)] = 0.0;
  }
}

/// Sorts the rows by support and lays out Y.
template <int R>
void arrange(GeneralBank<R>& b, const Problem::Rows& rows, const Layout& layout, std::vector<int>& place) {
  b.resize(rows.n);
  const int n_supports = layout.n_supports();
  if (static_cast<int>(b.count.size()) < n_supports + 1) b.count.resize(at(n_supports + 1));
  if (static_cast<int>(b.g_offset.size()) < rows.n) {
    b.g_offset.resize(rows.id.size());
    b.row.resize(rows.id.size());
    place.resize(rows.id.size());
  }
  if (b.Y.size() < rows.G.size()) b.Y.resize(rows.G.size());
  std::fill_n(b.count.begin(), n_supports + 1, 0);
  for (int i = 0; i < rows.n; ++i) ++b.count[at(rows.support[at(i)] + 1)];
  b.runs.clear();
  int y = 0;
  for (int k = 0; k < n_supports; ++k) {
    const int begin = b.count[at(k)];
    const int end = begin + b.count[at(k + 1)];
    b.count[at(k + 1)] = end;
    if (end == begin) continue;
    const int stride = static_cast<int>(layout.support(k).tiles.size()) * R * kTile;
    b.runs.push_back({k, begin, end, y, stride});
    const auto& tiles = layout.support(k).tiles;
    for (int j = begin; j < end; ++j, y += stride) b.row[at(j)] = {tiles.data(), static_cast<int>(tiles.size()), y};
  }
  for (int i = 0; i < rows.n; ++i) {
    const int j = b.count[at(rows.support[at(i)])]++;
    b.order[at(j)] = i;
    place[at(i)] = j;
    b.g_offset[at(j)] = rows.offset[at(i)];
  }
}

void set_weight(AlignedVector& weight, AlignedVector& inverse, AlignedVector& live, int i, double value) {
  weight[at(i)] = value;
  inverse[at(i)] = 1.0 / value;
  live[at(i)] = 1.0;
}

/// Patterns, order and weights of a problem (everything but the start).
void prepare(const Problem& problem, const Options& options, State& s) {
  const Layout& layout = *s.layout;
  const bool smoothed = options.mode == Mode::Smoothed;
  arrange(s.cones, problem.cones(), layout, s.cone_place);
  arrange(s.lines, problem.half_lines(), layout, s.line_place);
  s.bounds.resize(4 * problem.n_bound_groups());
  s.n_cones = problem.n_cones();
  s.n_lines = problem.n_half_lines();
  s.n_bounds = problem.n_bounds();
  if (static_cast<int>(s.bound_slot.size()) < s.n_bounds) s.bound_slot.resize(at(s.n_bounds));
  if (static_cast<int>(s.bound_tile.size()) < s.bounds.groups) {
    s.bound_tile.resize(at(s.bounds.groups));
    s.bound_sign.resize(at(4 * s.bounds.groups));
  }
  const auto weight_of = [smoothed](double sigma, double theta) {
    if (smoothed && !(sigma > 0)) core::throw_invalid("sigma", std::to_string(sigma), "greater than 0 in Smoothed mode");
    return smoothed ? sigma : theta;
  };
  for (int i = 0; i < s.n_cones; ++i) {
    const double sigma = problem.cones().sigma[at(s.cones.order[at(i)])];
    set_weight(s.cones.weight, s.cones.inv_weight, s.cones.live, i, weight_of(sigma, 2.0));
  }
  for (int i = 0; i < s.n_lines; ++i) {
    const double sigma = problem.half_lines().sigma[at(s.lines.order[at(i)])];
    set_weight(s.lines.weight, s.lines.inv_weight, s.lines.live, i, weight_of(sigma, 1.0));
  }
  idle_lanes(s.cones);
  idle_lanes(s.lines);
  s.bounds.n = 0;
  idle_lanes(s.bounds);
  s.bounds.n = 4 * s.bounds.groups;
  for (int g = 0; g < s.bounds.groups; ++g) {
    const auto& group = problem.bound_groups()[at(g)];
    s.bound_tile[at(g)] = group.tile;
    for (int lane = 0; lane < kTile; ++lane) {
      s.bound_sign[at(4 * g + lane)] = group.sign[lane];
      if (group.index[lane] < 0) continue;
      s.bound_slot[at(group.index[lane])] = 4 * g + lane;
      set_weight(s.bounds.weight, s.bounds.inv_weight, s.bounds.live, 4 * g + lane, weight_of(group.sigma[lane], 1.0));
    }
  }
  std::ranges::fill(s.below, 0);
  const auto couple = [&](const Run& run) {
    const auto& tiles = layout.support(run.support).tiles;
    for (std::size_t j = 0; j < tiles.size(); ++j) {
      for (std::size_t i = j + 1; i < tiles.size(); ++i) s.below[at(tiles[j])] |= std::uint64_t{1} << tiles[i];
    }
  };
  for (const Run& run : s.cones.runs) couple(run);
  for (const Run& run : s.lines.runs) couple(run);
  for (const auto& q : layout.q_tiles()) {
    if (q.row != q.column) s.below[at(q.column)] |= std::uint64_t{1} << q.row;
  }
  s.factor.analyse(s.below);
}

void Attempt::start_cold(double least_slack, bool careful) {
  careful_ = careful;
  std::ranges::fill(s_.x, 0.0);
  double violation = 0;
  const auto& cones = problem_.cones();
  const auto& lines = problem_.half_lines();
  for (int i = 0; i < cones.n; ++i) violation = std::max(violation, -slack_of<3>(cones.g.data() + 3 * i, 1));
  for (int i = 0; i < lines.n; ++i) violation = std::max(violation, -lines.g[at(i)]);
  for (int g = 0; g < s_.bounds.groups; ++g) {
    for (const double offset : problem_.bound_groups()[at(g)].offset) violation = std::max(violation, -offset);
  }
  const double s0 = std::max(least_slack, 0.3 * violation);
  double sharpest = 0;
  for_each_bank([&](auto& b) {
    for (int i = 0; i < 4 * b.groups; ++i) sharpest = std::max(sharpest, b.weight[at(i)]);
  });
  const double centre = smoothed_ && sharpest > 0 ? std::max(1.0, kColdCentre * impulse_ / sharpest) : kColdCentre * impulse_;
  for_each_row(s_.cones, [&](int i, int base) {
    const double* g = cones.g.data() + 3 * s_.cones.order[at(i)];
    double* w = s_.cones.w.data() + base;
    w[0] = std::max(g[0], s0 + std::hypot(g[1], g[2]));
    w[4] = g[1];
    w[8] = g[2];
    double* r = s_.cones.r_p.data() + base;
    r[0] = w[0] - g[0];
    r[4] = r[8] = 0;
    set_inverse<3>(s_.cones.z.data() + base, w, centre * s_.cones.weight[at(i)]);
  });
  for_each_row(s_.lines, [&](int i, int base) {
    const double g = lines.g[at(s_.lines.order[at(i)])];
    s_.lines.w[at(base)] = std::max(g, s0);
    s_.lines.r_p[at(base)] = s_.lines.w[at(base)] - g;
    s_.lines.z[at(base)] = centre * s_.lines.weight[at(i)] / s_.lines.w[at(base)];
  });
  for_each_row(s_.bounds, [&](int i, int base) {
    if (s_.bounds.live[at(i)] == 0) return;
    const double g = problem_.bound_groups()[at(i / 4)].offset[i % 4];
    s_.bounds.w[at(base)] = std::max(g, s0);
    s_.bounds.r_p[at(base)] = s_.bounds.w[at(base)] - g;
    s_.bounds.z[at(base)] = centre * s_.bounds.weight[at(i)] / s_.bounds.w[at(base)];
  });
  primal_ = 1.0;
}

/// Pushes w inside and takes z from memory. @returns how far w moved, relative to its slack
template <int R>
double start_row(double* w, double* z, double* r_p, const double* remembered, double target, bool smoothed) {
  const double slack = slack_of<R>(w, 4);
  double before[R];
  for (int r = 0; r < R; ++r) before[r] = w[4 * r];
  if (remembered != nullptr) {
    for (int r = 0; r < R; ++r) z[4 * r] = remembered[r];
    if (slack < kWarmSlack) {
      if (smoothed) set_inverse<R>(w, z, target);
      else w[0] += kWarmSlack - slack;
    }
  } else {
    if (slack < kColdSlack) w[0] += kColdSlack - slack;
    set_inverse<R>(z, w, target);
  }
  double moved = 0;
  for (int r = 0; r < R; ++r) {
    r_p[4 * r] = w[4 * r] - before[r];
    moved = std::max(moved, std::abs(r_p[4 * r]));
  }
  return moved / slack_of<R>(w, 4);
}

bool Attempt::try_start_warm() {
  const Memory& m = s_.memory;
  if (!m.valid || m.mode != options_.mode || n_rows_ == 0) return false;
  std::ranges::copy(s_.x_memory, s_.x.begin());
  const double centre = smoothed_ ? 1.0 : kColdCentre * impulse_;
  double worst = 0;
  int hits = 0;
  const auto look_up = [&](const Memory::Rows& rows, std::uint64_t id, int hint, int components) -> const double* {
    const int i = rows.find(id, hint);
    if (i < 0) return nullptr;
    ++hits;
    return rows.z.data() + components * i;
  };
  const auto general = [&]<int R>(GeneralBank<R>& b, const Problem::Rows& rows, const Memory::Rows& memory) {
    for_each_row(b, [&](int i, int base) {
      const int original = b.order[at(i)];
      double gx[R];
      multiply_raw<R>(rows, original, layout_, s_.x.data(), gx);
      for (int r = 0; r < R; ++r) b.w[at(base + 4 * r)] = gx[r] + rows.g[at(R * original + r)];
      const double* z = look_up(memory, rows.id[at(original)], original, R);
      worst = std::max(worst, start_row<R>(b.w.data() + base, b.z.data() + base, b.r_p.data() + base, z, centre * b.weight[at(i)],
                                            smoothed_));
    });
  };
  general(s_.cones, problem_.cones(), m.cones);
  general(s_.lines, problem_.half_lines(), m.lines);
  for (int k = 0; k < s_.n_bounds; ++k) {
    const int i = s_.bound_slot[at(k)];
    const int tile = s_.bound_tile[at(i / 4)];
    s_.bounds.w[at(i)] = s_.bound_sign[at(i)] * s_.x[at(4 * tile + i % 4)] + problem_.bound_groups()[at(i / 4)].offset[i % 4];
    const double* z = look_up(m.bounds, problem_.bound_id(k), k, 1);
    worst = std::max(worst, start_row<1>(&s_.bounds.w[at(i)], &s_.bounds.z[at(i)], &s_.bounds.r_p[at(i)], z,
                                         centre * s_.bounds.weight[at(i)], smoothed_));
  }
  primal_ = 1.0;
  return hits > 0 && worst <= (smoothed_ ? 8.0 : 4.0);
}

Spread Attempt::scale() {
  Spread spread;
  for_each_bank([&]<int R>(Bank<R>& b) {
    for (int g = 0; g < b.groups; ++g) scale_group<R>(b, g, t_end_, spread);
  });
  return spread;
}

/// H = Q + YᵀY and, while w ≠ Gx + g, p = V·r_p.
void Attempt::build() {
  TileFactor& h = s_.factor;
  h.set_zero();
  const double* q = problem_.Q_tiles();
  for (const auto& tile : layout_.q_tiles()) {
    double* t = h.tile(h.index(tile.row, tile.column));
    for (int k = 0; k < 16; k += 4) store(t + k, load(q + k));
    q += 16;
  }
  add_hessian(s_.cones, problem_.cones(), layout_, h);
  add_hessian(s_.lines, problem_.half_lines(), layout_, h);
  for (int g = 0; g < s_.bounds.groups; ++g) {
    double* t = h.tile(h.index(s_.bound_tile[at(g)], s_.bound_tile[at(g)]));
    const V4 y = load_one(s_.bounds.v, g) * load_one(s_.bound_sign, g);
    const V4 d = y * y;
    for (int lane = 0; lane < kTile; ++lane) t[5 * lane] += d[lane];
  }
  if (primal_ == 0) return;
  for_each_bank([&]<int R>(Bank<R>& b) {
    for (int g = 0; g < b.groups; ++g) scale_primal_residual<R>(b, g, primal_);
  });
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

/// Factor of H; where rounding leaves a pivot that is not positive, of H with a slightly larger diagonal.
bool Attempt::factorise() {
  if (s_.factor.factorise()) return true;
  for (const double delta : {1e-15, 1e-13, 1e-11}) {
    build();
    for (int t = 0; t < layout_.tiles(); ++t) {
      double* d = s_.factor.tile(s_.factor.index(t, t));
      for (int lane = 0; lane < kTile; ++lane) d[5 * lane] *= 1 + delta;
    }
    if (s_.factor.factorise()) return true;
  }
  return false;
}

/// out += Yᵀa, a[k] by bank
void Attempt::add_all_transposed(const AlignedVector& cones, const AlignedVector& lines, const AlignedVector& bounds, double* out) const {
  add_transposed(s_.cones, layout_, cones, out);
  add_transposed(s_.lines, layout_, lines, out);
  for (int g = 0; g < s_.bounds.groups; ++g) {
    double* to = out + 4 * s_.bound_tile[at(g)];
    store(to, load(to) + load_one(s_.bounds.v, g) * load_one(s_.bound_sign, g) * load_one(bounds, g));
  }
}

/// Calls f(bank, group, Y·dx of the group) for all groups.
template <class F>
void Attempt::for_each_product(const double* dx, F&& f) {
  for (int g = 0; g < s_.cones.groups; ++g) f(static_cast<Bank<3>&>(s_.cones), g, multiply_group(s_.cones, g, dx));
  for (int g = 0; g < s_.lines.groups; ++g) f(static_cast<Bank<1>&>(s_.lines), g, multiply_group(s_.lines, g, dx));
  for (int g = 0; g < s_.bounds.groups; ++g) {
    const V4 y = load_one(s_.bounds.v, g) * load_one(s_.bound_sign, g);
    f(s_.bounds, g, Element<1>{{y * load(dx + 4 * s_.bound_tile[at(g)])}});
  }
}

/// Improves dx by the residual of H·dx = rhs (rhs in s_.scale).
void Attempt::refine(double* dx) {
  double* residual = s_.scratch.data();
  for (int k = 0; k < 2; ++k) {
    std::ranges::copy(s_.scale, s_.scratch.begin());
    subtract_product(dx, residual);
    for_each_product(dx, [&]<int R>(Bank<R>& b, int g, Element<R> u) {
      for (auto& e : u.e) e = -e;
      store_element<R>(b.u, g, u);
    });
    add_all_transposed(s_.cones.u, s_.lines.u, s_.bounds.u, residual);
    s_.factor.solve(residual);
    for (int i = 0; i < layout_.padded_size(); ++i) dx[i] += residual[i];
  }
}

/// Newton direction to t·weight·e (with Mehrotra's second-order term from the direction now in u, s when `corrector`) that takes
/// away the part `reduction` of both infeasibilities; less than 1 only with t > 0.
/// @returns the largest step that stays inside all cones
double Attempt::calc_direction(double t, bool corrector, double reduction) {
  const bool has_p = primal_ != 0 && reduction > 0;
  const bool has_c = t != 0 || corrector;
  double* dx = s_.dx.data();
  for (int k = 0; k < layout_.padded_size(); k += 4) store(dx + k, load(s_.gradient.data() + k) * reduction);
  if (has_c) {
    for_each_bank([&]<int R>(Bank<R>& b) {
      for (int g = 0; g < b.groups; ++g) {
        if (corrector) centring_group<R, true>(b, g, t);
        else centring_group<R, false>(b, g, t);
        auto c = load_element<R>(b.c, g);
        if (has_p) {
          const auto p = load_element<R>(b.p, g);
          for (int r = 0; r < R; ++r) c.e[r] += reduction * p.e[r];
        }
        if (reduction < 1) {
          const auto lambda = load_element<R>(b.lambda, g);
          for (int r = 0; r < R; ++r) c.e[r] -= (1 - reduction) * lambda.e[r];
        }
        store_element<R>(b.u, g, c);   // u is free here: the right-hand side c + p
      }
    });
  }
  if (has_c) add_all_transposed(s_.cones.u, s_.lines.u, s_.bounds.u, dx);
  else if (has_p) add_all_transposed(s_.cones.p, s_.lines.p, s_.bounds.p, dx);
  if (careful_) std::ranges::copy(s_.dx, s_.scale.begin());
  s_.factor.solve(dx);
  if (careful_) refine(dx);
  V4 inverse = all(1e-30);
  for_each_product(dx, [&]<int R>(Bank<R>& b, int g, const Element<R>& u) {
    direction_group<R>(b, g, u, has_p ? reduction : 0.0, has_c, inverse);
  });
  return 1.0 / largest(inverse);
}

/// Step inside the neighbourhood of the central path around t.
double Attempt::shorten(double alpha, double t) const {
  const double floor = (careful_ ? kCareful : kNeighbourhood) * t;
  for (int k = 0; k < 12; ++k, alpha *= kBacktrack) {
    V4 margin = all(1.0);
    const auto look = [&]<int R>(const Bank<R>& b) {
      for (int g = 0; g < b.groups; ++g) margin = min(margin, margin_group<R>(b, g, alpha, floor));
    };
    look(s_.cones);
    look(s_.lines);
    look(s_.bounds);
    if (largest(-margin) <= 0) break;
  }
  return alpha;
}

void Attempt::move(double alpha, double reduction) {
  for_each_bank([&]<int R>(Bank<R>& b) {
    for (int g = 0; g < b.groups; ++g) move_group<R>(b, g, alpha);
  });
  for (int t = 0; t < layout_.tiles(); ++t) {
    store(s_.x.data() + 4 * t, load(s_.x.data() + 4 * t) + alpha * load(s_.dx.data() + 4 * t));
  }
  primal_ *= 1 - alpha * reduction;   // exactly 0 after a full step
  calc_gradient();
}

/// One predictor(–corrector) step. @returns false when no progress is possible
bool Attempt::step() {
  const double largest_affine = calc_direction(t_end_, false, 1.0);
  const double affine = std::min(1.0, kToBoundary * largest_affine);
  if (!(affine > 0)) return false;
  const bool plain = n_rows_ == 0 || (smoothed_ ? affine >= (careful_ ? 1.0 : kPlainStep) : t_ < kNear * t_end_);
  double alpha = affine, reduction = 1;
  bool centred = false;
  if (plain) {
    alpha = shorten(affine, t_end_);
  } else {
    const double left = 1 - std::min(1.0, largest_affine);
    double t = t_end_ + left * std::sqrt(left) * (t_ - t_end_);   // exponent 1.5: measured best of 0.8 … 3
    alpha = std::min(1.0, kToBoundary * calc_direction(t, true, 1.0));
    alpha = shorten(alpha, t);
    if (alpha < std::max(0.5 * affine, kShort)) {
      // Centre. Where even the centre allows only short steps, μ is too small for the infeasibility that is left: go back up.
      const bool up = centred_ && affine < kTooShort;
      const double centring = std::max(1 - affine, 0.5);
      t = up ? kBackUp * std::max(t_, t_end_) : t_end_ + centring * (t_ - t_end_);
      reduction = up ? 0.0 : 1 - centring;
      alpha = shorten(std::min(1.0, kToBoundary * calc_direction(t, false, reduction)), t);
      centred = alpha > kPlainStep;
    }
  }
  if (!(alpha > 1e-10)) return false;
  centred_ = centred;
  move(alpha, reduction);
  return true;
}

/// Residuals from raw data. @returns whether stationarity and primal residual are within tolerance; when the primal one is not,
/// r_p is taken from the raw data.
bool Attempt::measure() {
  const int padded = layout_.padded_size();
  std::ranges::fill(s_.scratch, 0.0);
  std::ranges::fill(s_.scale, 0.0);
  double primal = 0;
  const auto general = [&]<int R>(GeneralBank<R>& b, const Problem::Rows& rows) {
    for_each_row(b, [&](int i, int base) {
      const int original = b.order[at(i)];
      double gx[R], z[R], size = 1;
      multiply_raw<R>(rows, original, layout_, s_.x.data(), gx);
      for (int r = 0; r < R; ++r) size = std::max(size, std::abs(rows.g[at(R * original + r)]));
      for (int r = 0; r < R; ++r) {
        b.r_p[at(base + 4 * r)] = b.w[at(base + 4 * r)] - (gx[r] + rows.g[at(R * original + r)]);
        primal = std::max(primal, std::abs(b.r_p[at(base + 4 * r)]) / size);
        z[r] = b.z[at(base + 4 * r)];
      }
      add_transposed_raw<R>(rows, original, layout_, z, s_.scratch.data(), s_.scale.data());
    });
  };
  general(s_.cones, problem_.cones());
  general(s_.lines, problem_.half_lines());
  for_each_row(s_.bounds, [&](int i, int) {
    if (s_.bounds.live[at(i)] == 0) return;
    const int position = 4 * s_.bound_tile[at(i / 4)] + i % 4;
    const double sign = s_.bound_sign[at(i)], g = problem_.bound_groups()[at(i / 4)].offset[i % 4];
    s_.bounds.r_p[at(i)] = s_.bounds.w[at(i)] - (sign * s_.x[at(position)] + g);
    primal = std::max(primal, std::abs(s_.bounds.r_p[at(i)]) / std::max(1.0, std::abs(g)));
    s_.scratch[at(position)] += sign * s_.bounds.z[at(i)];
    s_.scale[at(position)] += s_.bounds.z[at(i)];
  });
  double stationarity = 0;
  for (int i = 0; i < padded; ++i) {
    const double b = problem_.b_padded()[i];
    const double minus = s_.gradient[at(i)];   // −(Qx + b)
    const double size = std::max({1.0, std::abs(b), std::abs(minus + b), s_.scale[at(i)]});
    stationarity = std::max(stationarity, std::abs(minus + s_.scratch[at(i)]) / size);
  }
  residuals_.stationarity = stationarity;
  residuals_.primal = primal;
  primal_ = primal > 0 ? 1.0 : 0.0;
  return stationarity <= options_.tol_kkt && primal <= options_.tol_kkt;
}

/// −gᵀz > radius·‖Gᵀz‖₁: no ‖x‖∞ ≤ radius is feasible (eq. 11). In Smoothed mode it is enough that none has all slacks above
/// 1e-6 (the central path needs an interior). Call after measure(), which leaves Gᵀz in scratch.
bool Attempt::prove_infeasible() {
  double gz = 0, norm = 0, size = 0;   // size: Σ z₀
  for_each_row(s_.cones, [&](int i, int base) {
    for (int r = 0; r < 3; ++r) gz += problem_.cones().g[at(3 * s_.cones.order[at(i)] + r)] * s_.cones.z[at(base + 4 * r)];
    size += s_.cones.z[at(base)];
  });
  for_each_row(s_.lines, [&](int i, int base) {
    gz += problem_.half_lines().g[at(s_.lines.order[at(i)])] * s_.lines.z[at(base)];
    size += s_.lines.z[at(base)];
  });
  for_each_row(s_.bounds, [&](int i, int base) {
    if (s_.bounds.live[at(i)] == 0) return;
    gz += problem_.bound_groups()[at(i / 4)].offset[i % 4] * s_.bounds.z[at(base)];
    size += s_.bounds.z[at(base)];
  });
  for (const double v : s_.scratch) norm += std::abs(v);
  return -gz > options_.infeasible_radius * norm - (smoothed_ ? kNoInterior * size : 0.0);
}

void Attempt::remember_z() {
  for_each_bank([&]<int R>(Bank<R>& b) { std::copy_n(b.z.begin(), 4 * R * b.groups, b.z_saved.begin()); });
}

Status Attempt::run(int& iterations) {
  const bool centred = smoothed_ || options_.sensitivities || careful_;
  t_end_ = smoothed_ ? 1.0 : (centred ? kExactEnd * options_.tol_complementarity * impulse_ : 0.0);
  const double tolerance = options_.tol_complementarity;
  remember_z();
  calc_gradient();
  centred_ = false;
  int polish = 0;
  double last_off = std::numeric_limits<double>::infinity();
  for (int iteration = 0;; ++iteration) {
    const Spread spread = scale();
    t_ = n_rows_ > 0 ? sum(spread.mean) / n_rows_ : 0.0;
    const double worst = largest(spread.worst) / impulse_;
    const double off = largest(spread.off);
    residuals_.complementarity = smoothed_ ? off : worst;
    if (!(t_ >= 0) || !std::isfinite(t_) || !std::isfinite(largest(spread.off))) return Status::NumericalFailure;
    if (!smoothed_ && t_ >= kWarmMemory * impulse_) remember_z();
    // Rounding of w∘z can keep a sharp row just above the tolerance: then two iterates within ten times of it will do.
    const bool close = smoothed_ ? off <= tolerance || std::max(off, last_off) <= 10 * tolerance : worst <= tolerance;
    last_off = off;
    const bool good = close && measure();
    if (good) {
      const bool at_centre = smoothed_ || !centred || n_rows_ == 0 || off <= kCentreTolerance * t_end_;
      if (at_centre || ++polish > 6) return Status::Solved;
    }
    if (options_.cancel != nullptr && options_.cancel->load(std::memory_order_relaxed)) {
      (void)measure();
      return Status::Cancelled;
    }
    if (iteration >= 8 && primal_ != 0 && iteration % 2 == 0) {
      (void)measure();
      if (prove_infeasible()) {
        infeasible_ = true;
        return Status::Infeasible;
      }
    }
    if (iteration == options_.max_iterations) {
      (void)measure();
      return Status::MaxIterations;
    }
    build();
    ++iterations;
    if (!factorise() || !step()) return good ? Status::Solved : Status::NumericalFailure;
  }
}

/// Factor of H at the final point, in the scaling that scale() has just made.
void Attempt::leave_factor() {
  build();
  s_.has_factor = factorise();
}

template <int R>
void remember_rows(const Bank<R>& b, const std::vector<int>& place, int n, const std::vector<std::uint64_t>& id, bool saved,
                   Memory::Rows& out) {
  if (static_cast<int>(out.id.size()) < n) {
    out.id.resize(id.size());
    out.z.resize(R * id.size());
  }
  out.n = n;
  const AlignedVector& z = saved ? b.z_saved : b.z;
  for (int k = 0; k < n; ++k) {
    const int i = place[at(k)];
    out.id[at(k)] = id[at(k)];
    for (int r = 0; r < R; ++r) out.z[at(R * k + r)] = z[at((i / 4) * 4 * R + 4 * r + i % 4)];
  }
}

}  // namespace

/// Remembers a solved problem for the next warm start.
void remember(const Problem& problem, const Options& options, State& s) {
  const bool saved = options.mode == Mode::Exact;
  remember_rows(s.cones, s.cone_place, s.n_cones, problem.cones().id, saved, s.memory.cones);
  remember_rows(s.lines, s.line_place, s.n_lines, problem.half_lines().id, saved, s.memory.lines);
  if (static_cast<int>(s.memory.bounds.id.size()) < s.n_bounds) {
    s.memory.bounds.id.resize(at(s.n_bounds));
    s.memory.bounds.z.resize(at(s.n_bounds));
  }
  s.memory.bounds.n = s.n_bounds;
  for (int k = 0; k < s.n_bounds; ++k) {
    s.memory.bounds.id[at(k)] = problem.bound_id(k);
    s.memory.bounds.z[at(k)] = (saved ? s.bounds.z_saved : s.bounds.z)[at(s.bound_slot[at(k)])];
  }
  std::ranges::copy(s.x, s.x_memory.begin());
  s.memory.mode = options.mode;
  s.memory.valid = true;
}

/// Writes the iterate into the result, in the caller's order. @returns largest distance outside the cones
double write_result(const Problem& problem, const State& s, Result& result) {
  const Layout& layout = *s.layout;
  result.x.resize(layout.size());
  for (int i = 0; i < layout.size(); ++i) result.x[i] = s.x[at(layout.position(i))];
  double outside = 0;
  result.w_cone.resize_columns(problem.n_cones());
  result.z_cone.resize_columns(problem.n_cones());
  for (int k = 0; k < problem.n_cones(); ++k) {
    const int i = s.cone_place[at(k)];
    const double* w = s.cones.w.data() + (i / 4) * 12 + i % 4;
    const double* z = s.cones.z.data() + (i / 4) * 12 + i % 4;
    for (int r = 0; r < 3; ++r) {
      result.w_cone(r, k) = w[4 * r];
      result.z_cone(r, k) = z[4 * r];
    }
    outside = std::max({outside, -slack_of<3>(w, 4), -slack_of<3>(z, 4)});
  }
  const auto write = [&outside](int n, const std::vector<int>& place, const Bank<1>& b, Numbers& w, Numbers& z) {
    w.resize_numbers(n);
    z.resize_numbers(n);
    for (int k = 0; k < n; ++k) {
      w[k] = b.w[at(place[at(k)])];
      z[k] = b.z[at(place[at(k)])];
      outside = std::max({outside, -w[k], -z[k]});
    }
  };
  write(problem.n_half_lines(), s.line_place, s.lines, result.w_half_line, result.z_half_line);
  write(problem.n_bounds(), s.bound_slot, s.bounds, result.w_bound, result.z_bound);
  return outside;
}

}  // namespace detail

void Options::validate() const {
  const auto in = [](const char* field, double value, double low, double high) {
    if (!(value >= low && value <= high)) {
      core::throw_invalid(field, std::to_string(value), "a number in [" + std::to_string(low) + ", " + std::to_string(high) + "]");
    }
  };
  in("tol_complementarity", tol_complementarity, 1e-11, 1e-2);
  in("tol_kkt", tol_kkt, 1e-12, 1e-2);
  if (max_iterations < 1) core::throw_invalid("max_iterations", std::to_string(max_iterations), "at least 1");
  core::require_positive("infeasible_radius", infeasible_radius);
}

core::Status solve(const Problem& problem, const Options& options, Workspace& work, Result& result) {
  using core::Status;
  options.validate();
  detail::State& s = work.state();
  if (problem.layout_ptr() != s.layout) core::throw_invalid("work", "a workspace of another layout", "the layout of the problem");
  s.has_factor = false;
  detail::prepare(problem, options, s);
  detail::Attempt attempt(problem, options, s);
  result.iterations = 0;
  result.warm_started = options.warm_start && attempt.try_start_warm();
  Status status = Status::NumericalFailure;
  const auto done = [&status] { return status == Status::Solved || status == Status::Cancelled; };
  if (result.warm_started) {
    status = attempt.run(result.iterations);
    if (!done()) result.warm_started = false;
  }
  for (const double slack : {detail::kColdSlack, detail::kFarSlack}) {
    if (done()) break;
    attempt.start_cold(slack, slack == detail::kFarSlack);
    status = attempt.run(result.iterations);
    if (status == Status::Infeasible) break;
  }
  if (status == Status::Solved) {
    if (options.sensitivities) attempt.leave_factor();
    detail::remember(problem, options, s);
  } else {
    s.memory.valid = false;
  }
  result.residuals = attempt.residuals();
  result.residuals.cone = std::max(0.0, detail::write_result(problem, s, result));
  result.status = status;
  return status;
}

}  // namespace stiction::cone
