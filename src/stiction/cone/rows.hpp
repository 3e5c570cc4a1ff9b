#pragma once

#include "stiction/cone/scaling.hpp"
#include "stiction/cone/simd.hpp"
#include "stiction/cone/state.hpp"

/// Products with G and Y = VG, row by row in the tile layout (docs/theory/cone.md, eq. 8).
namespace stiction::cone::detail {

/// Y = VG of a run of rows, V read from the bank's lanes.
inline void scale_rows(GeneralBank<3>& b, const Problem::Rows& rows, const Run& run, int tiles) {
  for (int i = run.begin; i < run.end; ++i) {
    const double* v = b.v.data() + (i / 4) * 24 + i % 4;
    const double* from = rows.G.data() + b.g_offset[static_cast<std::size_t>(i)];
    double* to = b.Y.data() + run.y + (i - run.begin) * run.stride;
    const V4 v00 = all(v[0]), v01 = all(v[4]), v02 = all(v[8]), v11 = all(v[12]), v12 = all(v[16]), v22 = all(v[20]);
    for (int t = 0; t < tiles; ++t, from += 12, to += 12) {
      const V4 g0 = load(from), g1 = load(from + 4), g2 = load(from + 8);
      store(to, v00 * g0 + (v01 * g1 + v02 * g2));
      store(to + 4, v01 * g0 + (v11 * g1 + v12 * g2));
      store(to + 8, v02 * g0 + (v12 * g1 + v22 * g2));
    }
  }
}
inline void scale_rows(GeneralBank<1>& b, const Problem::Rows& rows, const Run& run, int tiles) {
  for (int i = run.begin; i < run.end; ++i) {
    const double v = b.v[static_cast<std::size_t>(i)];
    const double* from = rows.G.data() + b.g_offset[static_cast<std::size_t>(i)];
    double* to = b.Y.data() + run.y + (i - run.begin) * run.stride;
    for (int t = 0; t < tiles; ++t) store(to + 4 * t, load(from + 4 * t) * v);
  }
}

/// One or two tiles of H, of neighbouring slots i and i + 1 against slot j: += Σ rows left·rightᵀ.
template <int R, int N>
inline void add_products(double* t0, double* t1, const double* left, const double* right, int n, int stride) {
  V4 c[N][4];
  for (int q = 0; q < 4; ++q) {
    c[0][q] = load(t0 + 4 * q);
    if constexpr (N == 2) c[1][q] = load(t1 + 4 * q);
  }
  for (int row = 0; row < n; ++row, left += stride, right += stride) {
    for (int r = 0; r < R; ++r) {
      V4 l[N];
      for (int m = 0; m < N; ++m) l[m] = load(left + 4 * (R * m + r));
      for (int q = 0; q < 4; ++q) {
        const V4 x = all(right[4 * r + q]);
        for (int m = 0; m < N; ++m) c[m][q] += l[m] * x;
      }
    }
  }
  for (int q = 0; q < 4; ++q) {
    store(t0 + 4 * q, c[0][q]);
    if constexpr (N == 2) store(t1 + 4 * q, c[1][q]);
  }
}

/// H += YᵀY over all rows; Y is made on the way.
template <int R>
inline void add_hessian(GeneralBank<R>& b, const Problem::Rows& rows, const Layout& layout, TileFactor& h) {
  for (const Run& run : b.runs) {
    const auto& tiles = layout.support(run.support).tiles;
    const int k = static_cast<int>(tiles.size());
    scale_rows(b, rows, run, k);
    const double* y = b.Y.data() + run.y;
    const int n = run.end - run.begin;
    const auto target = [&](int i, int j) {
      return h.tile(h.index(tiles[static_cast<std::size_t>(i)], tiles[static_cast<std::size_t>(j)]));
    };
    for (int j = 0; j < k; ++j) {
      int i = j;
      for (; i + 1 < k; i += 2) add_products<R, 2>(target(i, j), target(i + 1, j), y + i * R * 4, y + j * R * 4, n, run.stride);
      if (i < k) add_products<R, 1>(target(i, j), nullptr, y + i * R * 4, y + j * R * 4, n, run.stride);
    }
  }
}

/// out += Yᵀa, a given in the lanes of the bank
template <int R>
inline void add_transposed(const GeneralBank<R>& b, const Layout& layout, const AlignedVector& a, double* out) {
  for (const Run& run : b.runs) {
    const auto& tiles = layout.support(run.support).tiles;
    const int k = static_cast<int>(tiles.size());
    constexpr int kBlock = 4;   // rows at a time, their values side by side
    for (int begin = run.begin; begin < run.end; begin += kBlock) {
      const int n = run.end - begin < kBlock ? run.end - begin : kBlock;
      double value[kBlock * R];
      for (int i = 0; i < n; ++i) {
        const double* from = a.data() + ((begin + i) / 4) * 4 * R + (begin + i) % 4;
        for (int r = 0; r < R; ++r) value[R * i + r] = from[4 * r];
      }
      const double* rows = b.Y.data() + run.y + (begin - run.begin) * run.stride;
      for (int j = 0; j < k; ++j, rows += 4 * R) {
        double* to = out + 4 * tiles[static_cast<std::size_t>(j)];
        V4 acc[R] = {};
        acc[0] = load(to);
        const double* y = rows;
        for (int i = 0; i < n; ++i, y += run.stride) {
          for (int r = 0; r < R; ++r) acc[r] += load(y + 4 * r) * value[R * i + r];
        }
        if constexpr (R == 3) store(to, acc[0] + (acc[1] + acc[2]));
        else store(to, acc[0]);
      }
    }
  }
}

/// Y·d of the four rows of a group
template <int R>
inline Element<R> multiply_group(const GeneralBank<R>& b, int g, const double* d) {
  V4 acc[R][4] = {};
#pragma GCC unroll 4
  for (int lane = 0; lane < 4; ++lane) {
    const int i = 4 * g + lane;
    if (i >= b.n) break;
    const auto& row = b.row[static_cast<std::size_t>(i)];
    const double* y = b.Y.data() + row.y;
    V4 a[R] = {};
    for (int j = 0; j < row.n_tiles; ++j, y += 4 * R) {
      const V4 x = load(d + 4 * row.tiles[j]);
      for (int r = 0; r < R; ++r) a[r] += load(y + 4 * r) * x;
    }
    for (int r = 0; r < R; ++r) acc[r][lane] = a[r];
  }
  Element<R> u;
  for (int r = 0; r < R; ++r) u.e[r] = sums(acc[r][0], acc[r][1], acc[r][2], acc[r][3]);
  return u;
}

/// G·x of row `at` of `rows`, raw data.
template <int R>
inline void multiply_raw(const Problem::Rows& rows, int at, const Layout& layout, const double* x, double* out) {
  const auto& tiles = layout.support(rows.support[static_cast<std::size_t>(at)]).tiles;
  const double* from = rows.G.data() + rows.offset[static_cast<std::size_t>(at)];
  V4 acc[R] = {};
  for (const int t : tiles) {
    for (int r = 0; r < R; ++r, from += 4) acc[r] += load(from) * load(x + 4 * t);
  }
  for (int r = 0; r < R; ++r) out[r] = sum(acc[r]);
}

/// out += Gᵀz and size += |G|ᵀ|z| of row `at`, raw data.
template <int R>
inline void add_transposed_raw(const Problem::Rows& rows, int at, const Layout& layout, const double* z, double* out, double* size) {
  const auto& tiles = layout.support(rows.support[static_cast<std::size_t>(at)]).tiles;
  const double* from = rows.G.data() + rows.offset[static_cast<std::size_t>(at)];
  for (const int t : tiles) {
    V4 o = load(out + 4 * t), a = load(size + 4 * t);
    for (int r = 0; r < R; ++r, from += 4) {
      const V4 term = load(from) * z[r];
      o += term;
      a += abs(term);
    }
    store(out + 4 * t, o);
    store(size + 4 * t, a);
  }
}

}  // namespace stiction::cone::detail
