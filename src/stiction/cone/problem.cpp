#include "stiction/cone/problem.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::cone {
namespace {

constexpr int kTileSize = kTile * kTile;

void require_index(std::string_view name, int i, int n) {
  if (i < 0 || i >= n) core::throw_invalid(name, std::to_string(i), "an index in 0 … " + std::to_string(n - 1));
}

void require_unit(const Unit& unit) {
  if (unit.length > 0 && unit.work > 0 && std::isfinite(unit.length + unit.work)) return;
  core::require_positive("unit.length", unit.length);
  core::require_positive("unit.work", unit.work);
}

/// 0 when all are finite, else NaN: one branch for a whole row.
double poison(const double* values, int n) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += values[i] * 0.0;
  return sum;
}

void reserve(Problem::Rows& rows, int components, int n, int doubles) {
  const auto size = static_cast<std::size_t>(n);
  rows.id.resize(size);
  rows.support.resize(size);
  rows.offset.resize(size);
  rows.sigma.resize(size);
  rows.unit.resize(size);
  rows.g.resize(size * static_cast<std::size_t>(components));
  if (static_cast<std::size_t>(doubles) > rows.G.size()) rows.G.resize(static_cast<std::size_t>(doubles));
}

}  // namespace

Problem::Problem(std::shared_ptr<const Layout> layout, int max_cones, int max_half_lines) : layout_(std::move(layout)) {
  if (!layout_) core::throw_invalid("layout", "none", "a layout");
  if (max_cones < 0) core::throw_invalid("max_cones", std::to_string(max_cones), "at least 0");
  if (max_half_lines < 0) core::throw_invalid("max_half_lines", std::to_string(max_half_lines), "at least 0");
  int widest = 1;
  for (int s = 0; s < layout_->n_supports(); ++s) {
    widest = std::max(widest, static_cast<int>(layout_->support(s).tiles.size()));
  }
  Q_.resize(layout_->q_tiles().size() * kTileSize);
  b_.resize(static_cast<std::size_t>(layout_->padded_size()));
  length_.resize(b_.size());
  gradient_.resize(b_.size());
  std::ranges::fill(length_, 1.0);
  std::ranges::fill(gradient_, 1.0);
  reserve(cones_, 3, max_cones, max_cones * widest * 3 * kTile);
  reserve(lines_, 1, max_half_lines, max_half_lines * widest * kTile);
  bound_groups_.resize(static_cast<std::size_t>(2 * layout_->tiles()));
  bound_id_.resize(static_cast<std::size_t>(2 * layout_->size()));
  clear();
}

void Problem::clear() {
  std::ranges::fill(Q_, 0.0);
  std::ranges::fill(b_, 0.0);
  // Lanes without a variable: unit diagonal, so that they stay at 0 and never disturb the factor.
  for (int t = 0; t < layout_->tiles(); ++t) {
    for (int lane = 0; lane < kTile; ++lane) Q_[static_cast<std::size_t>(layout_->q_tile(t, t) * kTileSize + lane * 5)] = 1.0;
  }
  for (int i = 0; i < layout_->size(); ++i) {
    Q_[static_cast<std::size_t>(layout_->q_tile(layout_->tile(i), layout_->tile(i)) * kTileSize + layout_->lane(i) * 5)] = 0.0;
  }
  cones_.n = cones_.used = lines_.n = lines_.used = 0;
  n_bound_groups_ = n_bounds_ = 0;
}

void Problem::set_Q(int i, int j, double v) {
  require_index("i", i, layout_->size());
  require_index("j", j, layout_->size());
  if (!std::isfinite(v)) core::require_finite("Q", v);
  if (layout_->group(i) != layout_->group(j)) {
    core::throw_invalid("Q", "an entry (" + std::to_string(i) + ", " + std::to_string(j) + ")", "variables of one group");
  }
  const auto put = [&](int row, int column) {
    const int tile = layout_->q_tile(layout_->tile(row), layout_->tile(column));
    if (tile >= 0) Q_[static_cast<std::size_t>(tile * kTileSize + layout_->lane(column) * kTile + layout_->lane(row))] = v;
  };
  if (layout_->tile(i) >= layout_->tile(j)) put(i, j);
  if (layout_->tile(j) >= layout_->tile(i)) put(j, i);
}

void Problem::set_b(int i, double v) {
  require_index("i", i, layout_->size());
  if (!std::isfinite(v)) core::require_finite("b", v);
  b_[static_cast<std::size_t>(layout_->position(i))] = v;
}

void Problem::set_unit(int i, Unit unit) {
  require_index("i", i, layout_->size());
  require_unit(unit);
  const auto at = static_cast<std::size_t>(layout_->position(i));
  length_[at] = unit.length;
  gradient_[at] = unit.work / unit.length;
}

int Problem::add_row(Rows& rows, int components, std::uint64_t id, int support, const double* G, const double* g, double sigma, Unit unit) {
  require_index("support", support, layout_->n_supports());
  const auto& where = layout_->support(support);
  const int k = static_cast<int>(where.variables.size());
  if (std::isnan(poison(G, components * k))) core::throw_invalid("G", "a number that is not finite", "finite numbers");
  if (std::isnan(poison(g, components))) core::throw_invalid("g", "a number that is not finite", "finite numbers");
  if (!(sigma >= 0) || !std::isfinite(sigma)) core::require_nonnegative("sigma", sigma);
  require_unit(unit);
  const int doubles = static_cast<int>(where.tiles.size()) * components * kTile;
  const int i = rows.n;
  if (i >= static_cast<int>(rows.id.size()) || rows.used + doubles > static_cast<int>(rows.G.size())) {
    reserve(rows, components, std::max(2 * i, std::max(8, static_cast<int>(rows.id.size()))), 2 * (rows.used + doubles));
    ++growths_;
  }
  const auto at = static_cast<std::size_t>(i);
  rows.id[at] = id;
  rows.support[at] = support;
  rows.offset[at] = rows.used;
  rows.sigma[at] = sigma;
  rows.unit[at] = unit;
  for (int r = 0; r < components; ++r) rows.g[at * static_cast<std::size_t>(components) + static_cast<std::size_t>(r)] = g[r];
  double* to = rows.G.data() + rows.used;
  std::fill(to, to + doubles, 0.0);
  for (int c = 0; c < k; ++c) {
    double* column = to + where.slot[static_cast<std::size_t>(c)] * components * kTile + where.lane[static_cast<std::size_t>(c)];
    for (int r = 0; r < components; ++r) column[r * kTile] = G[r * k + c];
  }
  rows.used += doubles;
  return rows.n++;
}

int Problem::add_cone(std::uint64_t id, int support, const double* G, const double* g, double sigma, Unit unit) {
  return add_row(cones_, 3, id, support, G, g, sigma, unit);
}

int Problem::add_half_line(std::uint64_t id, int support, const double* G, double g, double sigma, Unit unit) {
  return add_row(lines_, 1, id, support, G, &g, sigma, unit);
}

int Problem::add_bound(std::uint64_t id, int variable, double sign, double offset, double sigma, Unit unit, double give) {
  require_index("variable", variable, layout_->size());
  if (sign != 1.0 && sign != -1.0) core::throw_invalid("sign", std::to_string(sign), "1 or -1");
  if (!std::isfinite(offset)) core::require_finite("offset", offset);
  if (!(sigma >= 0) || !std::isfinite(sigma)) core::require_nonnegative("sigma", sigma);
  if (!(give >= 0) || !std::isfinite(give)) core::require_nonnegative("give", give);
  require_unit(unit);
  const int tile = layout_->tile(variable);
  const int lane = layout_->lane(variable);
  int g = 0;
  while (g < n_bound_groups_ &&
         (bound_groups_[static_cast<std::size_t>(g)].tile != tile || bound_groups_[static_cast<std::size_t>(g)].sign[lane] != 0.0)) {
    ++g;
  }
  if (g == n_bound_groups_) {
    if (g == static_cast<int>(bound_groups_.size())) {
      bound_groups_.resize(static_cast<std::size_t>(2 * g));
      ++growths_;
    }
    bound_groups_[static_cast<std::size_t>(g)] = BoundGroup{};
    bound_groups_[static_cast<std::size_t>(g)].tile = tile;
    ++n_bound_groups_;
  }
  if (n_bounds_ == static_cast<int>(bound_id_.size())) {
    bound_id_.resize(static_cast<std::size_t>(2 * n_bounds_));
    ++growths_;
  }
  auto& group = bound_groups_[static_cast<std::size_t>(g)];
  group.sign[lane] = sign;
  group.offset[lane] = offset;
  group.sigma[lane] = sigma;
  group.give[lane] = give;
  group.unit[lane] = unit;
  group.index[lane] = n_bounds_;
  bound_id_[static_cast<std::size_t>(n_bounds_)] = id;
  return n_bounds_++;
}

}  // namespace stiction::cone
