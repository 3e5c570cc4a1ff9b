#include "stiction/cone/attempt.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stiction::cone::detail {
namespace {

constexpr double kColdCentre = 0.003;  // w∘z = θ·S·kColdCentre·e, in works of the row
constexpr double kWarmSlack = 1e-4;    // smallest slack of w in a warm attempt, in lengths of the row

template <int R>
double slack_of(const double* w, int stride) {
  if constexpr (R == 1)
    return w[0];
  else
    return w[0] - std::sqrt(w[stride] * w[stride] + w[2 * stride] * w[2 * stride]);
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

/// Pushes w inside its cone and takes z from memory. @returns how far w moved, relative to its slack
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

}  // namespace

/// A soft bound starts feasible and on the central path: w − give·z = gx + g and wz = target.
void Attempt::start_giving(int i, double gx, double centre) {
  Group<1>& group = s_.bounds.of(i);
  const double give = *lane(&group.give, i);
  if (give == 0) return;
  const double g = gx + *lane(group.g, i), target = centre * *lane(&group.weight, i);
  const double root = std::sqrt(g * g + 4 * give * target);
  const double w = g >= 0 ? (g + root) / 2 : 2 * give * target / (root - g);  // without cancellation
  *lane(group.w, i) = w;
  *lane(group.z, i) = target / w;
  *lane(group.r_p, i) = 0;
}

void Attempt::start_cold(double least_slack, bool careful) {
  careful_ = careful;
  blunt();
  std::ranges::fill(s_.x, 0.0);
  each_group(s_.cones, [](Group<3>& group) { group.g[0] -= std::exchange(group.shift, V4{}); });
  V4 outside{};
  for_each_group([&]<int R>(const Group<R>& group) {
    V4 violation = -slack_of_group<R>(group.g) / group.length;
    if constexpr (R == 1) violation = group.give > V4{} ? V4{} : violation;
    outside = max(outside, violation);
  });
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
  for (int k = 0; s_.gives && k < s_.n_bounds; ++k) start_giving(s_.bound_slot[at(k)], 0, centre);
  primal_ = 1.0;
}

/// Sets w = Gx + g in every row at the x of the state. Soft bounds are started as well.
/// @param visit  called with the group of a row, its place, the memory of its kind, its id and its index in the problem
template <class Visit>
void Attempt::start_at_x(double centre, Visit&& visit) {
  const Memory& m = s_.memory;
  const auto general = [&]<int R>(GeneralBank<R>& b, const Problem::Rows& rows, const Memory::Rows& memory) {
    for (int i = 0; i < b.n; ++i) {
      const int original = b.order[at(i)];
      double gx[R];
      multiply_raw<R>(rows, original, layout_, s_.x.data(), gx);
      double* w = lane(b.of(i).w, i);
      for (int r = 0; r < R; ++r) w[4 * r] = gx[r] + rows.g[at(R * original + r)];
      visit(b.of(i), i, memory, rows.id[at(original)], original);
    }
  };
  general(s_.cones, problem_.cones(), m.cones);
  general(s_.lines, problem_.half_lines(), m.lines);
  for (int k = 0; k < s_.n_bounds; ++k) {
    const int i = s_.bound_slot[at(k)];
    Group<1>& group = s_.bounds.of(i);
    const double gx = s_.bound_sign[at(i)] * s_.x[at(4 * s_.bound_tile[at(i / 4)] + i % 4)];
    if (*lane(&group.give, i) > 0) {
      start_giving(i, gx, centre);
      continue;
    }
    *lane(group.w, i) = gx + problem_.bound_groups()[at(i / 4)].offset[i % 4];
    visit(group, i, m.bounds, problem_.bound_id(k), k);
  }
  primal_ = 1.0;
}

bool Attempt::try_start_warm() {
  const Memory& m = s_.memory;
  if (!m.valid || m.mode != options_.mode || n_rows_ == 0) return false;
  std::ranges::copy(s_.x_memory, s_.x.begin());
  const double centre = smoothed_ ? 1.0 : kColdCentre * impulse_;
  blunt();
  double worst = 0;
  int hits = 0;
  start_at_x(centre, [&]<int R>(Group<R>& group, int i, const Memory::Rows& memory, std::uint64_t id, int hint) {
    const int k = memory.find(id, hint);
    hits += k >= 0;
    worst = std::max(worst, start_row<R>(lane(group.w, i), lane(group.z, i), lane(group.r_p, i), k < 0 ? nullptr : memory.z.data() + R * k,
                                         centre * *lane(&group.weight, i), *lane(&group.length, i), smoothed_));
  });
  return hits > 0 && worst <= (smoothed_ ? 8.0 : 4.0);
}

bool Attempt::try_start_at(const Eigen::VectorXd& x) {
  if (!smoothed_ || x.size() != layout_.size()) return false;
  std::ranges::fill(s_.x, 0.0);
  for (int i = 0; i < layout_.size(); ++i) s_.x[at(layout_.position(i))] = x[i];
  bool inside = true;
  start_at_x(1.0, [&]<int R>(Group<R>& group, int i, const Memory::Rows&, std::uint64_t, int) {
    inside = inside && slack_of<R>(lane(group.w, i), 4) > 0;
    set_inverse<R>(lane(group.z, i), lane(group.w, i), *lane(&group.weight, i));
    for (int r = 0; r < R; ++r) lane(group.r_p, i)[4 * r] = 0;
  });
  return inside;
}

}  // namespace stiction::cone::detail
