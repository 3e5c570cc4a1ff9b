#include "stiction/cone/tile_factor.hpp"

#include <algorithm>

#include "stiction/cone/simd.hpp"

namespace stiction::cone::detail {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A (column-major, symmetric, both halves filled) ← L⁻¹ of its Cholesky factor A = LLᵀ, column-major, zeros above.
/// LDLᵀ without square roots on the critical path, then one vector square root.
inline bool invert_factor(double* t) {
  const double a00 = t[0], a10 = t[1], a20 = t[2], a30 = t[3];
  const double i0 = 1.0 / a00;
  const double l10 = a10 * i0, l20 = a20 * i0, l30 = a30 * i0;
  const double a11 = t[5] - l10 * a10, a21 = t[6] - l20 * a10, a31 = t[7] - l30 * a10;
  const double i1 = 1.0 / a11;
  const double l21 = a21 * i1, l31 = a31 * i1;
  const double a22 = (t[10] - l20 * a20) - l21 * a21, a32 = (t[11] - l30 * a20) - l31 * a21;
  const double i2 = 1.0 / a22;
  const double l32 = a32 * i2;
  const double a33 = ((t[15] - l30 * a30) - l31 * a31) - l32 * a32;
  const double i3 = 1.0 / a33;
  if (!(a00 > 0 && a11 > 0 && a22 > 0 && a33 > 0)) return false;
  const V4 s = sqrt(V4{i0, i1, i2, i3});
  const double x20 = l21 * l10 - l20;
  const double x31 = l32 * l21 - l31;
  const double x30 = l31 * l10 - l32 * x20 - l30;
  store(t, V4{1.0, -l10, x20, x30} * s);
  store(t + 4, V4{0.0, 1.0, -l21, x31} * s);
  store(t + 8, V4{0.0, 0.0, 1.0, -l32} * s);
  store(t + 12, V4{0.0, 0.0, 0.0, 1.0} * s);
  return true;
}

}  // namespace

TileFactor::TileFactor(int tiles)
    : n_(tiles),
      below_(static_cast<std::size_t>(tiles)),
      column_(below_),
      row_(below_),
      index_(static_cast<std::size_t>(tiles * tiles)),
      column_start_(static_cast<std::size_t>(tiles + 1)),
      block_start_(column_start_),
      row_start_(column_start_) {
  const auto lower = static_cast<std::size_t>(tiles * (tiles + 1) / 2);
  targets_.reserve(lower);
  row_entries_.reserve(lower);
  std::size_t pairs = 0;
  for (int j = 0; j < tiles; ++j) pairs += static_cast<std::size_t>((tiles - j) * (tiles - j - 1) / 2);
  terms_.reserve(2 * pairs);
  blocks_.reserve(lower);
  values_.resize(lower * 16);
}

bool TileFactor::analyse(const std::vector<TileMask>& below) {
  if (analysed_ && below == below_) return false;
  analysed_ = true;
  std::ranges::copy(below, below_.begin());
  std::ranges::copy(below, column_.begin());
  std::ranges::fill(row_, TileMask{});
  std::ranges::fill(index_, -1);
  n_stored_ = 0;
  for (int j = 0; j < n_; ++j) {
    TileMask rows = column_[at(j)];
    index_[at(j * n_ + j)] = n_stored_++;
    rows.for_each([&](int i) {
      index_[at(i * n_ + j)] = n_stored_++;
      row_[at(i)].set(j);
    });
    if (const int parent = rows.first(); parent >= 0) {  // fill-in: the tiles below column j also appear in the column of its first tile
      rows.reset(parent);
      column_[at(parent)] |= rows;
    }
  }
  plan();
  return true;
}

/// The order in which factorise() and solve4() go through the tiles.
void TileFactor::plan() {
  targets_.clear();
  blocks_.clear();
  terms_.clear();
  row_entries_.clear();
  for (int k = 0; k < n_; ++k) {
    column_start_[at(k)] = static_cast<int>(targets_.size());
    block_start_[at(k)] = static_cast<int>(blocks_.size());
    const auto add_target = [&](int i) { targets_.push_back({offset(i, k), static_cast<std::uint32_t>(i)}); };
    add_target(k);
    column_[at(k)].for_each(add_target);
    const TileMask& left = row_[at(k)];  // columns before k only
    for (std::size_t first = at(column_start_[at(k)]); first < targets_.size();) {
      const TileMask columns = row_[targets_[first].row] & left;
      std::size_t end = first + 1;
      while (end < targets_.size() && end - first < 3 && (row_[targets_[end].row] & left) == columns) ++end;
      if (!columns.empty()) {
        blocks_.push_back({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(end - first),
                           static_cast<std::uint32_t>(columns.count()), static_cast<std::uint32_t>(terms_.size())});
        columns.for_each([&](int j) {
          terms_.push_back(offset(k, j));
          for (std::size_t t = first; t < end; ++t) terms_.push_back(offset(static_cast<int>(targets_[t].row), j));
        });
      }
      first = end;
    }
    row_start_[at(k)] = static_cast<int>(row_entries_.size());
    left.for_each([&](int j) { row_entries_.push_back({index(k, j), j}); });
  }
  column_start_[at(n_)] = static_cast<int>(targets_.size());
  block_start_[at(n_)] = static_cast<int>(blocks_.size());
  row_start_[at(n_)] = static_cast<int>(row_entries_.size());
}

namespace {

/// Four columns of a tile, as named registers: GCC keeps an array of twelve vectors in memory.
struct Columns4 {
  V4 c0, c1, c2, c3;
  explicit Columns4(const double* t) : c0(load(t)), c1(load(t + 4)), c2(load(t + 8)), c3(load(t + 12)) {}
  void store_to(double* t) const { store(t, c0), store(t + 4, c1), store(t + 8, c2), store(t + 12, c3); }
};

template <int N>
inline void subtract(V4& x, V4& y, V4& z, V4 a, V4 b, V4 c, double factor) {
  const V4 f = all(factor);
  x -= a * f;
  if constexpr (N > 1) y -= b * f;
  if constexpr (N > 2) z -= c * f;
}

/// N = 1 … 3 tiles: tₘ −= Σ aₘbᵀ over `count` terms. Unused tiles are not touched.
template <int N>
inline void update(double* values, const std::uint32_t* term, int count, double* t0, double* t1, double* t2) {
  Columns4 x(t0), y(N > 1 ? t1 : t0), z(N > 2 ? t2 : t0);
  for (; count > 0; --count, term += N + 1) {
    const double* b = values + term[0];
    const double* a0 = values + term[1];
    const double* a1 = N > 1 ? values + term[2] : a0;
    const double* a2 = N > 2 ? values + term[3] : a0;
#pragma GCC unroll 4
    for (int p = 0; p < 16; p += 4) {
      const V4 c0 = load(a0 + p), c1 = load(a1 + p), c2 = load(a2 + p);
      subtract<N>(x.c0, y.c0, z.c0, c0, c1, c2, b[p]);
      subtract<N>(x.c1, y.c1, z.c1, c0, c1, c2, b[p + 1]);
      subtract<N>(x.c2, y.c2, z.c2, c0, c1, c2, b[p + 2]);
      subtract<N>(x.c3, y.c3, z.c3, c0, c1, c2, b[p + 3]);
    }
  }
  x.store_to(t0);
  if constexpr (N > 1) y.store_to(t1);
  if constexpr (N > 2) z.store_to(t2);
}

}  // namespace

bool TileFactor::factorise(double* x) {
  double* const values = values_.data();
  const Target* target = targets_.data();
  const Block* block = blocks_.data();
  for (int k = 0; k < n_; ++k) {
    for (const Block* end = blocks_.data() + block_start_[static_cast<std::size_t>(k + 1)]; block != end; ++block) {
      const std::uint32_t* term = terms_.data() + block->first;
      const Target* to = targets_.data() + block->target;
      if (block->width == 1)
        update<1>(values, term, block->count, values + to[0].tile, nullptr, nullptr);
      else if (block->width == 2)
        update<2>(values, term, block->count, values + to[0].tile, values + to[1].tile, nullptr);
      else
        update<3>(values, term, block->count, values + to[0].tile, values + to[1].tile, values + to[2].tile);
    }
    double* d = values + target->tile;
    if (!invert_factor(d)) return false;
    const V4 r = load(x + 4 * k);
    const V4 y = (load(d) * all(r[0]) + load(d + 4) * all(r[1])) + (load(d + 8) * all(r[2]) + load(d + 12) * all(r[3]));
    store(x + 4 * k, y);
    const V4 y0 = all(y[0]), y1 = all(y[1]), y2 = all(y[2]), y3 = all(y[3]);
    const V4 d0 = all(d[0]), d1 = all(d[1]), d2 = all(d[2]), d3 = all(d[3]), d5 = all(d[5]), d6 = all(d[6]), d7 = all(d[7]),
             d10 = all(d[10]), d11 = all(d[11]), d15 = all(d[15]);
    // tile ← tile · L⁻ᵀ: column q = Σ_m c_m · X(q, m), X lower triangular
    for (const Target* end = targets_.data() + column_start_[static_cast<std::size_t>(k + 1)]; ++target != end;) {
      double* t = values + target->tile;
      double* to = x + 4 * target->row;
      const V4 c0 = load(t), c1 = load(t + 4), c2 = load(t + 8), c3 = load(t + 12);
      const V4 l0 = c0 * d0, l1 = c0 * d1 + c1 * d5, l2 = c0 * d2 + c1 * d6 + c2 * d10, l3 = (c0 * d3 + c1 * d7) + (c2 * d11 + c3 * d15);
      store(t, l0), store(t + 4, l1), store(t + 8, l2), store(t + 12, l3);
      store(to, load(to) - ((l0 * y0 + l1 * y1) + (l2 * y2 + l3 * y3)));
    }
  }
  return true;
}

void TileFactor::solve(double* x) const {
  const double* const values = values_.data();
  const Target* target = targets_.data();
  for (int k = 0; k < n_; ++k) {
    const double* d = values + target->tile;
    const V4 r = load(x + 4 * k);
    const V4 y = (load(d) * all(r[0]) + load(d + 4) * all(r[1])) + (load(d + 8) * all(r[2]) + load(d + 12) * all(r[3]));
    store(x + 4 * k, y);
    const V4 y0 = all(y[0]), y1 = all(y[1]), y2 = all(y[2]), y3 = all(y[3]);
    for (const Target* end = targets_.data() + column_start_[static_cast<std::size_t>(k + 1)]; ++target != end;) {
      const double* t = values + target->tile;
      double* to = x + 4 * target->row;
      store(to, load(to) - ((load(t) * y0 + load(t + 4) * y1) + (load(t + 8) * y2 + load(t + 12) * y3)));
    }
  }
  solve_backward(x);
}

void TileFactor::solve_backward(double* x) const {
  const double* const values = values_.data();
  for (int k = n_ - 1; k >= 0; --k) {
    const Target* target = targets_.data() + column_start_[static_cast<std::size_t>(k)];
    const double* d = values + target->tile;
    // The tiles are read from the last row on, so that the value found last is used last.
    const Target* at = targets_.data() + column_start_[static_cast<std::size_t>(k + 1)];
    V4 s0{}, s1{}, s2{}, s3{};
    while (--at != target) {
      const double* t = values + at->tile;
      const V4 y = load(x + 4 * at->row);
      s0 += load(t) * y;
      s1 += load(t + 4) * y;
      s2 += load(t + 8) * y;
      s3 += load(t + 12) * y;
    }
    const V4 acc = load(x + 4 * k) - sums(s0, s1, s2, s3);
    store(x + 4 * k, sums(load(d) * acc, load(d + 4) * acc, load(d + 8) * acc, load(d + 12) * acc));
  }
}

void TileFactor::solve4(double* x, int first) const {
  for (int k = first; k < n_; ++k) {
    double* xk = x + 16 * k;
    V4 r[4] = {load(xk), load(xk + 4), load(xk + 8), load(xk + 12)};
    for (int e = row_start_[static_cast<std::size_t>(k)]; e < row_start_[static_cast<std::size_t>(k + 1)]; ++e) {
      const Entry entry = row_entries_[static_cast<std::size_t>(e)];
      if (entry.other < first) continue;
      const double* t = tile(entry.tile);
      const double* y = x + 16 * entry.other;
      for (int m = 0; m < 4; ++m) {
        const V4 ym = load(y + 4 * m);
        for (int i = 0; i < 4; ++i) r[i] -= ym * t[4 * m + i];
      }
    }
    const double* d = tile(index(k, k));
    store(xk, r[0] * d[0]);
    store(xk + 4, r[0] * d[1] + r[1] * d[5]);
    store(xk + 8, r[0] * d[2] + r[1] * d[6] + r[2] * d[10]);
    store(xk + 12, r[0] * d[3] + r[1] * d[7] + r[2] * d[11] + r[3] * d[15]);
  }
  for (int k = n_ - 1; k >= 0; --k) {
    double* xk = x + 16 * k;
    V4 r[4] = {load(xk), load(xk + 4), load(xk + 8), load(xk + 12)};
    for (int c = column_start_[static_cast<std::size_t>(k)] + 1; c < column_start_[static_cast<std::size_t>(k + 1)]; ++c) {
      const double* t = values_.data() + targets_[static_cast<std::size_t>(c)].tile;
      const double* y = x + 16 * targets_[static_cast<std::size_t>(c)].row;
      for (int i = 0; i < 4; ++i) {
        const V4 yi = load(y + 4 * i);
        for (int m = 0; m < 4; ++m) r[m] -= yi * t[4 * m + i];
      }
    }
    const double* d = tile(index(k, k));
    store(xk, r[0] * d[0] + r[1] * d[1] + r[2] * d[2] + r[3] * d[3]);
    store(xk + 4, r[1] * d[5] + r[2] * d[6] + r[3] * d[7]);
    store(xk + 8, r[2] * d[10] + r[3] * d[11]);
    store(xk + 12, r[3] * d[15]);
  }
}

}  // namespace stiction::cone::detail
