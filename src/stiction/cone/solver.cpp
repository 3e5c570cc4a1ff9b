#include "stiction/cone/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "stiction/cone/rows.hpp"
#include "stiction/cone/scaling.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::cone {
namespace detail {
namespace {

using core::Status;

// Start of a cold attempt (docs/theory/cone.md §4).
constexpr double kColdCentre = 0.003;  // w∘z = θ·S·kColdCentre·e, in works of the row
constexpr double kColdSlack = 3e-3;    // smallest slack of w, in lengths of the row
constexpr double kWarmSlack = 1e-4;    // the same for a warm attempt
constexpr double kFarSlack = 1.0;      // slack of the retry
constexpr double kWarmMemory = 1e-5;   // z is remembered where t passes this
// Steps.
constexpr double kToBoundary = 0.99;  // part of the way to the boundary
constexpr double kBacktrack = 0.75;
constexpr double kNeighbourhood = 1e-3;    // smallest eigenvalue of the scaled point against its target
constexpr double kPlainStep = 0.5;         // a Newton step at least this long needs no corrector (Smoothed)
constexpr double kTooShort = 0.05;         // a predictor step below this from a centred point: raise μ
constexpr double kNear = 4;                // Exact: t this close to the centred end point takes plain Newton steps
constexpr double kNoInterior = 1e-6;       // slack, in lengths of the row
constexpr double kCareful = 0.1;           // the neighbourhood of the careful attempt
constexpr double kShort = 0.1;             // a corrected step below this is not worth taking: centre instead
constexpr double kBackUp = 10;             // by this
constexpr double kCentreTolerance = 1e-7;  // relative, of the centred end point in Exact mode
constexpr double kShiftEnd = 100;          // shifts follow the iterates until t passes this times the tolerance …
constexpr double kLeastShiftEnd = 1e-7;    // … or this, where it is more
constexpr int kShiftIterations = 30;       // … or for so many iterations
constexpr double kShiftAhead = 0.8;        // where on the way of the predictor the corrector's shifts are read: at its end they overshoot
constexpr double kShiftSlack = 0.5;        // a shift that becomes less takes at most this part of the slack from w, the rest from r_p
constexpr double kExactEnd = 0.05;         // that point is at this part of the tolerance

std::size_t at(int i) { return static_cast<std::size_t>(i); }

template <class B, class F>
inline void each_group(B& bank, F&& f) {
  auto* group = bank.group.data();
  for (const auto* end = group + bank.groups; group != end; ++group) f(*group);
}

class Attempt {
 public:
  Attempt(const Problem& problem, const Options& options, State& s)
      : problem_(problem),
        options_(options),
        s_(s),
        layout_(*s.layout),
        smoothed_(options.mode == Mode::Smoothed),
        n_rows_(problem.n_cones() + problem.n_half_lines() + problem.n_bounds()) {
    const double *b = problem.b_padded(), *unit = problem.gradient_padded();
    for (int i = 0; i < layout_.padded_size(); ++i) impulse_ = std::max(impulse_, std::abs(b[i]) / unit[i]);
    impulse_ = std::exp2(std::floor(std::log2(impulse_)));  // constant in b almost everywhere, as derivatives need
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
  void for_each_group(F&& f) {
    each_group(s_.cones, f);
    each_group(s_.lines, f);
    each_group(s_.bounds, f);
  }
  Spread scale();
  void build();
  void calc_gradient();
  void subtract_product(const double* v, double* out) const;
  bool factorise();
  template <class Member>
  void add_all_transposed(Member&& member, double* out) const;
  template <class F>
  void for_each_product(const double* dx, F&& f);
  void refine(double* dx);
  void set_rhs(double t, bool corrector, double reduction);
  double finish_direction(double t, bool corrector, double reduction);
  double calc_direction(double t, bool corrector, double reduction);
  double shorten(double alpha, double t);
  void move(double alpha, double reduction);
  void release_residual();
  void follow_tangents();
  void anticipate_tangents(double alpha);
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
  double t_ = 0;        // where the iterate is: mean of wᵀz / weight
  double t_end_ = 0;    // where it should go
  double impulse_ = 1;  // S = max(1, ‖b/unit‖∞) rounded down to a power of 2, by which complementarity is measured in Exact mode
  double primal_ = 0;   // r_p = primal_ · (stored r_p)
  Residuals residuals_;
  bool infeasible_ = false;
  bool careful_ = false;
  bool centred_ = false;    // the last step was a centring step of good length
  bool following_ = false;  // shifts follow the iterates
};

template <int R>
double slack_of(const double* w, int stride) {
  if constexpr (R == 1)
    return w[0];
  else
    return w[0] - std::sqrt(w[stride] * w[stride] + w[2 * stride] * w[2 * stride]);
}

template <int R>
V4 slack_of_group(const V4 (&w)[R]) {
  if constexpr (R == 1)
    return w[0];
  else
    return w[0] - sqrt(w[1] * w[1] + w[2] * w[2]);
}

/// z = value·w⁻¹ (Jordan inverse)
template <int R>
void set_inverse(double* z, const double* w, double value) {
  if constexpr (R == 1) {
    z[0] = value / w[0];
  } else {
    const double norm = std::sqrt(w[4] * w[4] + w[8] * w[8]);
    const double f = value / ((w[0] - norm) * (w[0] + norm));
    z[0] = f * w[0];
    z[4] = -f * w[4];
    z[8] = -f * w[8];
  }
}

template <int R>
void idle_lane(Bank<R>& b, int i) {
  Group<R>& group = b.of(i);
  for (V4* member : {group.w, group.z, group.r_p, group.u, group.p, group.c}) {
    for (int r = 0; r < R; ++r) lane(member, i)[4 * r] = 0.0;
  }
  for (int r = 0; r < R; ++r) lane(group.g, i)[4 * r] = 0.0;
  *lane(group.w, i) = *lane(group.z, i) = *lane(group.g, i) = 1.0;
  *lane(&group.weight, i) = *lane(&group.inv_weight, i) = *lane(&group.live, i) = *lane(&group.shift, i) = 0.0;
  *lane(&group.length, i) = 1.0;
  *lane(&group.inv_work, i) = 0.0;
}

/// Sorts the rows by support and lays out Y.
template <int R>
void arrange(GeneralBank<R>& b, const Problem::Rows& rows, const Layout& layout, std::vector<int>& place) {
  b.resize(rows.n);
  const int n_supports = layout.n_supports();
  if (static_cast<int>(b.places.size()) < n_supports) {
    b.places.resize(at(n_supports));
    b.runs.reserve(at(2 * n_supports));
  }
  if (static_cast<int>(b.g_offset.size()) < rows.n) {
    b.g_offset.resize(rows.id.size());
    b.row.resize(rows.id.size());
    place.resize(rows.id.size());
  }
  if (b.Y.size() < rows.G.size()) b.Y.resize(rows.G.size());
  auto* places = b.places.data();
  for (int k = 0; k < n_supports; ++k) places[k].count = 0;
  for (int i = 0; i < rows.n; ++i) ++places[rows.support[at(i)]].count;
  b.runs.clear();
  int j = 0, y = 0;
  const auto add_run = [&](int k, int n) {
    const auto& tiles = layout.support(k).tiles;
    const int n_tiles = static_cast<int>(tiles.size());
    const int stride = n_tiles * R * kTile;
    b.runs.push_back({k, j, j + n, y, stride});
    for (const int end = j + n; j < end; ++j, y += stride) b.row[at(j)] = {tiles.data(), n_tiles, y};
  };
  for (int k = 0; k < n_supports; ++k) {
    places[k].whole = j;
    if (places[k].count >= 4) add_run(k, places[k].count & ~3);
    places[k].whole_end = j;
  }
  b.whole_groups = j / 4;
  for (int k = 0; k < n_supports; ++k) {
    places[k].rest = j;
    if ((places[k].count & 3) != 0) add_run(k, places[k].count & 3);
  }
  for (int i = 0; i < rows.n; ++i) {
    auto& of = places[rows.support[at(i)]];
    const int to = of.whole < of.whole_end ? of.whole++ : of.rest++;
    b.order[at(to)] = i;
    place[at(i)] = to;
    b.g_offset[at(to)] = rows.offset[at(i)];
    for (int r = 0; r < R; ++r) lane(b.of(to).g, to)[4 * r] = rows.g[at(R * i + r)];
  }
}

template <int R>
void set_weight(Bank<R>& b, int i, double value, const Unit& unit) {
  Group<R>& group = b.of(i);
  *lane(&group.length, i) = unit.length;
  *lane(&group.inv_work, i) = 1.0 / unit.work;
  *lane(&group.weight, i) = value;
  *lane(&group.inv_weight, i) = 1.0 / value;
  *lane(&group.live, i) = 1.0;
  *lane(&group.shift, i) = 0.0;
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
  const auto weight_of = [smoothed](double sigma, double theta, const Unit& unit) {
    if (smoothed && !(sigma > 0)) core::throw_invalid("sigma", std::to_string(sigma), "greater than 0 in Smoothed mode");
    return smoothed ? sigma : theta * unit.work;
  };
  for (int i = 0; i < s.n_cones; ++i) {
    const auto row = at(s.cones.order[at(i)]);
    const Unit& unit = problem.cones().unit[row];
    set_weight(s.cones, i, weight_of(problem.cones().sigma[row], 2.0, unit), unit);
  }
  for (int i = 0; i < s.n_lines; ++i) {
    const auto row = at(s.lines.order[at(i)]);
    const Unit& unit = problem.half_lines().unit[row];
    set_weight(s.lines, i, weight_of(problem.half_lines().sigma[row], 1.0, unit), unit);
  }
  for (int i = s.n_cones; i < 4 * s.cones.groups; ++i) idle_lane(s.cones, i);
  for (int i = s.n_lines; i < 4 * s.lines.groups; ++i) idle_lane(s.lines, i);
  for (int g = 0; g < s.bounds.groups; ++g) {
    const auto& group = problem.bound_groups()[at(g)];
    s.bound_tile[at(g)] = group.tile;
    for (int lane = 0; lane < kTile; ++lane) {
      s.bound_sign[at(4 * g + lane)] = group.sign[lane];
      if (group.index[lane] < 0) {
        idle_lane(s.bounds, 4 * g + lane);
        continue;
      }
      s.bound_slot[at(group.index[lane])] = 4 * g + lane;
      detail::lane(s.bounds.of(4 * g).g, lane)[0] = group.offset[lane];
      set_weight(s.bounds, 4 * g + lane, weight_of(group.sigma[lane], 1.0, group.unit[lane]), group.unit[lane]);
    }
  }
  std::ranges::fill(s.below, TileMask{});
  const auto couple = [&](const Run& run) {
    const auto& tiles = layout.support(run.support).tiles;
    for (std::size_t j = 0; j < tiles.size(); ++j) {
      for (std::size_t i = j + 1; i < tiles.size(); ++i) s.below[at(tiles[j])].set(tiles[i]);
    }
  };
  for (const Run& run : s.cones.runs) couple(run);
  for (const Run& run : s.lines.runs) couple(run);
  for (const auto& q : layout.q_tiles()) {
    if (q.row != q.column) s.below[at(q.column)].set(q.row);
  }
  if (s.factor.analyse(s.below)) {
    s.q_of.assign(at(s.factor.n_tiles_stored()), -1);
    for (std::size_t q = 0; q < layout.q_tiles().size(); ++q) {
      s.q_of[at(s.factor.index(layout.q_tiles()[q].row, layout.q_tiles()[q].column))] = static_cast<int>(q);
    }
  }
}

void Attempt::start_cold(double least_slack, bool careful) {
  careful_ = careful;
  std::ranges::fill(s_.x, 0.0);
  each_group(s_.cones, [](Group<3>& group) { group.g[0] -= std::exchange(group.shift, V4{}); });
  V4 outside{};
  for_each_group([&]<int R>(const Group<R>& group) { outside = max(outside, -slack_of_group<R>(group.g) / group.length); });
  const double s0 = std::max(least_slack, 0.3 * largest(outside));
  V4 sharpest_lanes{};
  for_each_group([&](const auto& group) { sharpest_lanes = max(sharpest_lanes, group.weight * group.inv_work); });
  const double sharpest = largest(sharpest_lanes);
  const double centre = smoothed_ && sharpest > 0 ? std::max(1.0, kColdCentre * impulse_ / sharpest) : kColdCentre * impulse_;
  for_each_group([&]<int R>(Group<R>& group) {
    const V4 value = centre * group.weight, dead = 1.0 - group.live;
    const V4 norm = group.g[0] - slack_of_group<R>(group.g);
    const V4 w0 = max(group.g[0], s0 * group.length + norm);
    V4 f = value / w0;
    if constexpr (R == 3) {
      f = value / ((w0 - norm) * (w0 + norm));
      for (int r = 1; r < 3; ++r) {
        group.w[r] = group.g[r];
        group.z[r] = -f * group.g[r];
        group.r_p[r] = V4{};
      }
    }
    group.w[0] = w0;
    group.z[0] = (R == 3 ? f * w0 : f) + dead;
    group.r_p[0] = (w0 - group.g[0]) * group.live;
  });
  primal_ = 1.0;
}

/// Pushes w inside and takes z from memory. @returns how far w moved, relative to its slack
template <int R>
double start_row(double* w, double* z, double* r_p, const double* remembered, double target, double length, bool smoothed) {
  const double slack = slack_of<R>(w, 4);
  double before[R];
  for (int r = 0; r < R; ++r) before[r] = w[4 * r];
  if (remembered != nullptr) {
    for (int r = 0; r < R; ++r) z[4 * r] = remembered[r];
    if (slack < kWarmSlack * length) {
      if (smoothed)
        set_inverse<R>(w, z, target);
      else
        w[0] += kWarmSlack * length - slack;
    }
  } else {
    if (slack < kColdSlack * length) w[0] += kColdSlack * length - slack;
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
    for (int i = 0; i < b.n; ++i) {
      Group<R>& group = b.of(i);
      const int original = b.order[at(i)];
      double gx[R];
      multiply_raw<R>(rows, original, layout_, s_.x.data(), gx);
      double* w = lane(group.w, i);
      for (int r = 0; r < R; ++r) w[4 * r] = gx[r] + rows.g[at(R * original + r)];
      const double* z = look_up(memory, rows.id[at(original)], original, R);
      worst = std::max(worst, start_row<R>(w, lane(group.z, i), lane(group.r_p, i), z, centre * *lane(&group.weight, i),
                                           *lane(&group.length, i), smoothed_));
    }
  };
  general(s_.cones, problem_.cones(), m.cones);
  general(s_.lines, problem_.half_lines(), m.lines);
  for (int k = 0; k < s_.n_bounds; ++k) {
    const int i = s_.bound_slot[at(k)];
    Group<1>& group = s_.bounds.of(i);
    const int tile = s_.bound_tile[at(i / 4)];
    double* w = lane(group.w, i);
    *w = s_.bound_sign[at(i)] * s_.x[at(4 * tile + i % 4)] + problem_.bound_groups()[at(i / 4)].offset[i % 4];
    const double* z = look_up(m.bounds, problem_.bound_id(k), k, 1);
    worst = std::max(worst, start_row<1>(w, lane(group.z, i), lane(group.r_p, i), z, centre * *lane(&group.weight, i),
                                         *lane(&group.length, i), smoothed_));
  }
  primal_ = 1.0;
  return hits > 0 && worst <= (smoothed_ ? 8.0 : 4.0);
}

Spread Attempt::scale() {
  Spread spread;
  for_each_group([&]<int R>(Group<R>& group) { scale_group<R>(group, t_end_, spread); });
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
    const V4 d = y * y;
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

/// Factor of H, and the first half of solving for dx, which holds the right-hand side (kept in scale); where rounding leaves a pivot that is not positive, of H with a slightly
/// larger diagonal.
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
    store(to, load(to) + group->v[0] * load(s_.bound_sign.data() + 4 * g) * member(*group)[0]);
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

/// dx = the right-hand side of the Newton direction to t·weight·e (with Mehrotra's second-order term from the direction now in u, s
/// when `corrector`) that takes away the part `reduction` of both infeasibilities; less than 1 only with t > 0.
void Attempt::set_rhs(double t, bool corrector, double reduction) {
  const bool has_p = primal_ != 0 && reduction > 0;
  const bool has_c = t != 0 || corrector;
  double* dx = s_.dx.data();
  for (int k = 0; k < layout_.padded_size(); k += 4) store(dx + k, load(s_.gradient.data() + k) * reduction);
  if (has_c) {
    for_each_group([&]<int R>(Group<R>& group) {
      if (corrector)
        centring_group<R, true>(group, t);
      else
        centring_group<R, false>(group, t);
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
}

/// From the solution dx of H·dx = rhs, the rest of that direction. @returns the largest step that stays inside all cones
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

/// Step inside the neighbourhood of the central path around t.
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
    const double left = 1 - std::min(1.0, largest_affine);
    double t = t_end_ + left * std::sqrt(left) * (t_ - t_end_);  // exponent 1.5: measured best of 0.8 … 3
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
  double* gtz = s_.scratch.data();
  double* size = s_.scale.data();
  V4 primal_lanes{};
  const auto look = [&primal_lanes]<int R>(Group<R>& group, const Element<R>& gx) {
    V4 scale = group.length, largest_off{};
    for (int r = 0; r < R; ++r) {
      scale = max(abs(group.g[r]), scale);
      const V4 off = (group.w[r] - (gx.e[r] + group.g[r])) * group.live;
      group.r_p[r] = off;
      largest_off = max(largest_off, abs(off));
    }
    primal_lanes = max(primal_lanes, largest_off / scale);
  };
  const auto general = [&]<int R>(GeneralBank<R>& b, const Problem::Rows& rows) {
    for (int g = 0; g < b.groups; ++g) look(b.group[at(g)], multiply_raw_group<R>(b, rows, g, s_.x.data()));
    for (int i = 0; i < b.n; ++i) add_transposed_raw<R>(b, rows, i, gtz, size);
  };
  general(s_.cones, problem_.cones());
  general(s_.lines, problem_.half_lines());
  for (int g = 0; g < s_.bounds.groups; ++g) {
    Group<1>& group = s_.bounds.group[at(g)];
    const int position = 4 * s_.bound_tile[at(g)];
    const V4 sign = load(s_.bound_sign.data() + 4 * g);
    look(group, Element<1>{{sign * load(s_.x.data() + position)}});
    store(gtz + position, load(gtz + position) + sign * group.z[0]);
    store(size + position, load(size + position) + group.live * group.z[0]);
  }
  V4 stationarity_lanes{};
  for (int i = 0; i < padded; i += 4) {
    const V4 b = load(problem_.b_padded() + i);
    const V4 minus = load(s_.gradient.data() + i);  // −(Qx + b)
    const V4 scale = max(max(abs(b), abs(minus + b)), max(load(size + i), load(problem_.gradient_padded() + i)));
    stationarity_lanes = max(stationarity_lanes, abs(minus + load(gtz + i)) / scale);
  }
  const double stationarity = largest(stationarity_lanes), primal = largest(primal_lanes);
  residuals_.stationarity = stationarity;
  residuals_.primal = primal;
  primal_ = primal > 0 ? 1.0 : 0.0;
  return stationarity <= options_.tol_kkt && primal <= options_.tol_kkt;
}

/// −gᵀz > radius·‖Gᵀz‖₁: no ‖x‖∞ ≤ radius is feasible (eq. 11). In Smoothed mode it is enough that none has all slacks above
/// 1e-6 of its length (the central path needs an interior). Call after measure(), which leaves Gᵀz in scratch.
bool Attempt::prove_infeasible() {
  double gz = 0, norm = 0, size = 0;  // size: Σ z₀ℓ
  for (int i = 0; i < s_.n_cones; ++i) {
    const double* z = lane(s_.cones.of(i).z, i);
    for (int r = 0; r < 3; ++r) gz += problem_.cones().g[at(3 * s_.cones.order[at(i)] + r)] * z[4 * r];
    size += z[0] * *lane(&s_.cones.of(i).length, i);
  }
  for (int i = 0; i < s_.n_lines; ++i) {
    const double z = *lane(s_.lines.of(i).z, i);
    gz += problem_.half_lines().g[at(s_.lines.order[at(i)])] * z;
    size += z * *lane(&s_.lines.of(i).length, i);
  }
  for (int k = 0; k < s_.n_bounds; ++k) {
    const int i = s_.bound_slot[at(k)];
    const double z = *lane(s_.bounds.of(i).z, i);
    gz += problem_.bound_groups()[at(i / 4)].offset[i % 4] * z;
    size += z * *lane(&s_.bounds.of(i).length, i);
  }
  for (int i = 0; i < layout_.padded_size(); ++i) norm += std::abs(s_.scratch[at(i)]) * problem_.length_padded()[i];
  return -gz > options_.infeasible_radius * norm - (smoothed_ ? kNoInterior * size : 0.0);
}

void Attempt::remember_z() {
  for_each_group([&]<int R>(Group<R>& group) {
    for (int r = 0; r < R; ++r) group.z_saved[r] = group.z[r];
  });
}

/// Stores r_p itself, primal_ = 1.
void Attempt::release_residual() {
  for_each_group([&]<int R>(Group<R>& group) {
    for (auto& r : group.r_p) r *= all(primal_);
  });
  primal_ = 1.0;
}

/// Shift ← ‖(w₁, w₂)‖ in every cone (eq. 18). What it grows by, w₀ grows by as well: the point stays where it is in the interior, and feasible.
/// What it shrinks by is taken from w₀ as far as the slack allows, and is primal residual for the rest.
void Attempt::follow_tangents() {
  const bool feasible = primal_ == 0;
  release_residual();
  V4 off{};
  each_group(s_.cones, [&off](Group<3>& group) {
    const V4 tangent = sqrt(group.w[1] * group.w[1] + group.w[2] * group.w[2]);
    const V4 change = (tangent - group.shift) * group.live;
    const V4 taken = max(change, (tangent - group.w[0]) * all(kShiftSlack));
    group.shift += change;
    group.g[0] += change;
    group.w[0] += taken;
    group.r_p[0] += taken - change;
    off = max(off, abs(group.r_p[0]));
  });
  if (feasible && !(largest(off) > 0)) primal_ = 0.0;
}

/// Shift ← ‖(w₁, w₂)‖ where the predictor, now in u, is after a step α, in every cone: the corrector goes for what its own step will ask for. The point and
/// its scaling stay; what the shift changes by is primal residual.
void Attempt::anticipate_tangents(double alpha) {
  release_residual();
  each_group(s_.cones, [alpha](Group<3>& group) {
    const auto du = apply<-1>(group.v, load_element<3>(group.u));
    const V4 r = group.ratio * alpha;
    const V4 w1 = group.w[1] + r * du.e[1], w2 = group.w[2] + r * du.e[2];
    const V4 change = (sqrt(w1 * w1 + w2 * w2) - group.shift) * group.live;
    group.shift += change;
    group.g[0] += change;
    group.r_p[0] -= change;
  });
  for_each_group([]<int R>(Group<R>& group) { scale_primal_residual<R>(group, 1.0); });
}

Status Attempt::run(int& iterations) {
  const bool centred = smoothed_ || options_.sensitivities || careful_;
  t_end_ = smoothed_ ? 1.0 : (centred ? kExactEnd * options_.tol_complementarity * impulse_ : 0.0);
  const double tolerance = options_.tol_complementarity, shift_end = std::max(kLeastShiftEnd, kShiftEnd * tolerance);
  remember_z();
  calc_gradient();
  centred_ = false;
  int polish = 0;
  double last_off = std::numeric_limits<double>::infinity();
  for (int iteration = 0;; ++iteration) {
    following_ = options_.shift_by_tangent && iteration <= kShiftIterations && (iteration == 0 || t_ >= shift_end * impulse_);
    if (following_ && iteration > 0) follow_tangents();
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
    set_rhs(t_end_, false, 1.0);
    ++iterations;
    if (!factorise() || !step()) return good ? Status::Solved : Status::NumericalFailure;
  }
}

/// Factor of H at the final point, in the scaling that scale() has just made.
void Attempt::leave_factor() {
  build();
  std::ranges::fill(s_.dx, 0.0);
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
  for (int k = 0; k < n; ++k) {
    const int i = place[at(k)];
    out.id[at(k)] = id[at(k)];
    const double* z = lane(saved ? b.of(i).z_saved : b.of(i).z, i);
    for (int r = 0; r < R; ++r) out.z[at(R * k + r)] = z[4 * r];
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
    const Group<1>& group = s.bounds.of(s.bound_slot[at(k)]);
    s.memory.bounds.z[at(k)] = *lane(saved ? group.z_saved : group.z, s.bound_slot[at(k)]);
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
  result.shift_cone.resize_numbers(problem.n_cones());
  for (int k = 0; k < problem.n_cones(); ++k) {
    const int i = s.cone_place[at(k)];
    const double* w = lane(s.cones.of(i).w, i);
    const double* z = lane(s.cones.of(i).z, i);
    result.shift_cone[k] = *lane(&s.cones.of(i).shift, i);
    for (int r = 0; r < 3; ++r) {
      result.w_cone(r, k) = w[4 * r];
      result.z_cone(r, k) = z[4 * r];
    }
  }
  V4 cones_outside{};
  for (int g = 0; g < s.cones.groups; ++g) {
    const Group<3>& group = s.cones.group[at(g)];
    cones_outside = max(cones_outside, -min(slack_of_group<3>(group.w), slack_of_group<3>(group.z)));
  }
  outside = largest(cones_outside);
  const auto write = [&outside](int n, const std::vector<int>& place, const Bank<1>& b, Numbers& w, Numbers& z) {
    w.resize_numbers(n);
    z.resize_numbers(n);
    for (int k = 0; k < n; ++k) {
      const int i = place[at(k)];
      w[k] = *lane(b.of(i).w, i);
      z[k] = *lane(b.of(i).z, i);
      outside = std::max({outside, -w[k], -z[k]});
    }
  };
  write(problem.n_half_lines(), s.line_place, s.lines, result.w_half_line, result.z_half_line);
  write(problem.n_bounds(), s.bound_slot, s.bounds, result.w_bound, result.z_bound);
  return outside;
}

}  // namespace detail

void Options::validate() const {
  const auto text = [](double x) {
    std::ostringstream out;
    out << x;
    return out.str();
  };
  const auto in = [&](const char* field, double value, double low, double high) {
    if (!(value >= low && value <= high)) {
      core::throw_invalid(field, text(value), "a number in [" + text(low) + ", " + text(high) + "]");
    }
  };
  in("tol_complementarity", tol_complementarity, 1e-12, 1e-2);
  in("tol_kkt", tol_kkt, 1e-12, 1e-2);
  if (shift_by_tangent && mode != Mode::Exact) core::throw_invalid("shift_by_tangent", "true", "false in Smoothed mode");
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
