#include "stiction/cone/arrangement.hpp"

#include <algorithm>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::cone::detail {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

template <int R>
void harden(Group<R>& group, int i) {
  if constexpr (R == 1) {
    *lane(&group.give, i) = *lane(&group.yield, i) = 0.0;
    *lane(&group.hold, i) = 1.0;
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
  harden(group, i);
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
  harden(group, i);
}

double weight_of(bool smoothed, double sigma, double theta, const Unit& unit) {
  if (smoothed && !(sigma > 0)) core::throw_invalid("sigma", std::to_string(sigma), "greater than 0 in Smoothed mode");
  return smoothed ? sigma : theta * unit.work;
}

/// Sets the weights of the rows and the data of lanes without a row.
template <int R>
void set_weights(GeneralBank<R>& b, int n, const Problem::Rows& rows, bool smoothed) {
  constexpr double kDegree = R == 3 ? 2.0 : 1.0;
  for (int i = 0; i < n; ++i) {
    const auto row = at(b.order[at(i)]);
    set_weight(b, i, weight_of(smoothed, rows.sigma[row], kDegree, rows.unit[row]), rows.unit[row]);
  }
  for (int i = n; i < 4 * b.groups; ++i) idle_lane(b, i);
}

void set_bounds(const Problem& problem, bool smoothed, State& s) {
  s.gives = false;
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
      set_weight(s.bounds, 4 * g + lane, weight_of(smoothed, group.sigma[lane], 1.0, group.unit[lane]), group.unit[lane]);
      *detail::lane(&s.bounds.of(4 * g).give, lane) = group.give[lane];
      s.gives = s.gives || group.give[lane] > 0;
    }
  }
}

/// Finds the tiles that the rows and Q couple, and prepares the factor for them.
void find_factor(State& s) {
  const Layout& layout = *s.layout;
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
  if (!s.factor.analyse(s.below)) return;
  s.q_of.assign(at(s.factor.n_tiles_stored()), -1);
  for (std::size_t q = 0; q < layout.q_tiles().size(); ++q) {
    s.q_of[at(s.factor.index(layout.q_tiles()[q].row, layout.q_tiles()[q].column))] = static_cast<int>(q);
  }
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

void prepare(const Problem& problem, const Options& options, State& s) {
  const bool smoothed = options.mode == Mode::Smoothed;
  arrange(s.cones, problem.cones(), *s.layout, s.cone_place);
  arrange(s.lines, problem.half_lines(), *s.layout, s.line_place);
  s.bounds.resize(4 * problem.n_bound_groups());
  s.n_cones = problem.n_cones();
  s.n_lines = problem.n_half_lines();
  s.n_bounds = problem.n_bounds();
  if (static_cast<int>(s.bound_slot.size()) < s.n_bounds) s.bound_slot.resize(at(s.n_bounds));
  if (static_cast<int>(s.bound_tile.size()) < s.bounds.groups) {
    s.bound_tile.resize(at(s.bounds.groups));
    s.bound_sign.resize(at(4 * s.bounds.groups));
  }
  set_weights(s.cones, s.n_cones, problem.cones(), smoothed);
  set_weights(s.lines, s.n_lines, problem.half_lines(), smoothed);
  set_bounds(problem, smoothed, s);
  find_factor(s);
}

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

}  // namespace stiction::cone::detail
