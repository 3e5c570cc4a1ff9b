#include "stiction/cone/tile_factor.hpp"

#include <algorithm>
#include <bit>

#include "stiction/cone/simd.hpp"

namespace stiction::cone::detail {
namespace {

std::uint64_t bit(int i) { return std::uint64_t{1} << i; }

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
    : n_(tiles), below_(static_cast<std::size_t>(tiles)), column_(below_), row_(below_),
      index_(static_cast<std::size_t>(tiles * tiles)), column_start_(static_cast<std::size_t>(tiles + 1)),
      row_start_(column_start_) {
  const auto lower = static_cast<std::size_t>(tiles * (tiles + 1) / 2);
  targets_.reserve(lower);
  row_entries_.reserve(lower);
  std::size_t pairs = 0;
  for (int j = 0; j < tiles; ++j) pairs += static_cast<std::size_t>((tiles - j) * (tiles - j - 1) / 2);
  pairs_.reserve(pairs);
  values_.resize(lower * 16);
}

void TileFactor::analyse(const std::vector<std::uint64_t>& below) {
  if (analysed_ && below == below_) return;
  analysed_ = true;
  std::ranges::copy(below, below_.begin());
  std::ranges::copy(below, column_.begin());
  std::ranges::fill(row_, 0);
  std::ranges::fill(index_, -1);
  n_stored_ = 0;
  for (int j = 0; j < n_; ++j) {
    const std::uint64_t rows = column_[static_cast<std::size_t>(j)];
    if (rows != 0) column_[static_cast<std::size_t>(std::countr_zero(rows))] |= rows & (rows - 1);
    index_[static_cast<std::size_t>(j * n_ + j)] = n_stored_++;
    for (std::uint64_t m = rows; m != 0; m &= m - 1) {
      const int i = std::countr_zero(m);
      index_[static_cast<std::size_t>(i * n_ + j)] = n_stored_++;
      row_[static_cast<std::size_t>(i)] |= bit(j);
    }
  }
  targets_.clear();
  pairs_.clear();
  row_entries_.clear();
  for (int k = 0; k < n_; ++k) {
    column_start_[static_cast<std::size_t>(k)] = static_cast<int>(targets_.size());
    for (std::uint64_t m = bit(k) | column_[static_cast<std::size_t>(k)]; m != 0; m &= m - 1) {
      const int i = std::countr_zero(m);
      const auto first = static_cast<std::uint16_t>(pairs_.size());
      std::uint64_t shared = row_[static_cast<std::size_t>(i)] & row_[static_cast<std::size_t>(k)] & (bit(k) - 1);
      for (; shared != 0; shared &= shared - 1) {
        const int j = std::countr_zero(shared);
        pairs_.push_back({static_cast<std::uint16_t>(index(i, j)), static_cast<std::uint16_t>(index(k, j))});
      }
      targets_.push_back({static_cast<std::uint16_t>(index(i, k)), static_cast<std::uint16_t>(i), first,
                          static_cast<std::uint16_t>(pairs_.size() - first)});
    }
    row_start_[static_cast<std::size_t>(k)] = static_cast<int>(row_entries_.size());
    for (std::uint64_t m = row_[static_cast<std::size_t>(k)]; m != 0; m &= m - 1) {
      const int j = std::countr_zero(m);
      row_entries_.push_back({static_cast<std::uint16_t>(index(k, j)), static_cast<std::uint16_t>(j)});
    }
  }
  column_start_[static_cast<std::size_t>(n_)] = static_cast<int>(targets_.size());
  row_start_[static_cast<std::size_t>(n_)] = static_cast<int>(row_entries_.size());
}

void TileFactor::set_zero() { std::fill_n(values_.begin(), 16 * n_stored_, 0.0); }

bool TileFactor::factorise() {
  for (int k = 0; k < n_; ++k) {
    const double* inverse = nullptr;
    for (int c = column_start_[static_cast<std::size_t>(k)]; c < column_start_[static_cast<std::size_t>(k + 1)]; ++c) {
      const Target target = targets_[static_cast<std::size_t>(c)];
      double* t = tile(target.tile);
      V4 c0 = load(t), c1 = load(t + 4), c2 = load(t + 8), c3 = load(t + 12);
      const Pair* pair = pairs_.data() + target.first;
      for (int p = 0; p < target.count; ++p) {
        const double* a = tile(pair[p].a);
        const double* b = tile(pair[p].b);
        for (int m = 0; m < 4; ++m) {
          const V4 column = load(a + 4 * m);
          c0 -= column * b[4 * m];
          c1 -= column * b[4 * m + 1];
          c2 -= column * b[4 * m + 2];
          c3 -= column * b[4 * m + 3];
        }
      }
      if (inverse == nullptr) {
        store(t, c0), store(t + 4, c1), store(t + 8, c2), store(t + 12, c3);
        if (!invert_factor(t)) return false;
        inverse = t;
        continue;
      }
      // tile ← tile · L⁻ᵀ: column q = Σ_m c_m · X(q, m), X lower triangular
      const double* x = inverse;
      store(t, c0 * x[0]);
      store(t + 4, c0 * x[1] + c1 * x[5]);
      store(t + 8, c0 * x[2] + c1 * x[6] + c2 * x[10]);
      store(t + 12, (c0 * x[3] + c1 * x[7]) + (c2 * x[11] + c3 * x[15]));
    }
  }
  return true;
}

void TileFactor::solve(double* x) const {
  for (int k = 0; k < n_; ++k) {
    V4 acc = load(x + 4 * k);
    for (int e = row_start_[static_cast<std::size_t>(k)]; e < row_start_[static_cast<std::size_t>(k + 1)]; ++e) {
      const Entry entry = row_entries_[static_cast<std::size_t>(e)];
      const double* t = tile(entry.tile);
      const double* y = x + 4 * entry.other;
      acc -= (load(t) * y[0] + load(t + 4) * y[1]) + (load(t + 8) * y[2] + load(t + 12) * y[3]);
    }
    const double* d = tile(index(k, k));
    store(x + 4 * k, (load(d) * acc[0] + load(d + 4) * acc[1]) + (load(d + 8) * acc[2] + load(d + 12) * acc[3]));
  }
  for (int k = n_ - 1; k >= 0; --k) {
    V4 s0{}, s1{}, s2{}, s3{};
    for (int c = column_start_[static_cast<std::size_t>(k)] + 1; c < column_start_[static_cast<std::size_t>(k + 1)]; ++c) {
      const double* t = tile(targets_[static_cast<std::size_t>(c)].tile);
      const V4 y = load(x + 4 * targets_[static_cast<std::size_t>(c)].row);
      s0 += load(t) * y;
      s1 += load(t + 4) * y;
      s2 += load(t + 8) * y;
      s3 += load(t + 12) * y;
    }
    const V4 acc = load(x + 4 * k) - sums(s0, s1, s2, s3);
    const double* d = tile(index(k, k));
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
      const double* t = tile(targets_[static_cast<std::size_t>(c)].tile);
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
