#pragma once

#include "stiction/cone/scaling.hpp"
#include "stiction/cone/simd.hpp"
#include "stiction/cone/state.hpp"

/// Products with G and Y = VG, row by row in the tile layout (docs/theory/cone.md, eq. 8).
namespace stiction::cone::detail {

/// Y = VG of a run of rows, V read from the bank's lanes.
inline void scale_rows(GeneralBank<3>& b, const Problem::Rows& rows, const Run& run, int tiles) {
  double* to = b.Y.data() + run.y;
  const double* G = rows.G.data();
  const int* offset = b.g_offset.data();
  const Group<3>* groups = b.group.data();
  for (int i = run.begin; i < run.end; ++i) {
    const double* v = lane(groups[i / 4].v, i);
    const double* from = G + offset[i];
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
  double* to = b.Y.data() + run.y;
  const double* G = rows.G.data();
  const int* offset = b.g_offset.data();
  const Group<1>* groups = b.group.data();
  for (int i = run.begin; i < run.end; ++i) {
    const V4 v = all(*lane(groups[i / 4].v, i));
    const double* from = G + offset[i];
    for (int t = 0; t < tiles; ++t, from += 4, to += 4) store(to, load(from) * v);
  }
}

/// N tiles of H in one column, of neighbouring slots i … i + N − 1 against slot j: += Σ rows left·rightᵀ.
template <int R, int N>
inline void add_products(double* const (&t)[N], const double* left, const double* right, int n, int stride) {
  V4 c[N][4];
  for (int m = 0; m < N; ++m) {
    for (int q = 0; q < 4; ++q) c[m][q] = load(t[m] + 4 * q);
  }
  for (int row = 0; row < n; ++row, left += stride, right += stride) {
#pragma GCC unroll 3
    for (int r = 0; r < R; ++r) {
      V4 l[N];
      for (int m = 0; m < N; ++m) l[m] = load(left + 4 * (R * m + r));
      for (int q = 0; q < 4; ++q) {
        const V4 x = all(right[4 * r + q]);
        for (int m = 0; m < N; ++m) c[m][q] += l[m] * x;
      }
    }
  }
  for (int m = 0; m < N; ++m) {
    for (int q = 0; q < 4; ++q) store(t[m] + 4 * q, c[m][q]);
  }
}

/// The three lower tiles of two neighbouring slots against each other.
template <int R>
inline void add_corner(double* t00, double* t10, double* t11, const double* y, int n, int stride) {
  V4 a[4], b[4], c[4];
  for (int q = 0; q < 4; ++q) a[q] = load(t00 + 4 * q), b[q] = load(t10 + 4 * q), c[q] = load(t11 + 4 * q);
  for (int row = 0; row < n; ++row, y += stride) {
#pragma GCC unroll 3
    for (int r = 0; r < R; ++r) {
      const double* y0 = y + 4 * r;
      const double* y1 = y0 + 4 * R;
      const V4 l0 = load(y0), l1 = load(y1);
      for (int q = 0; q < 4; ++q) {
        const V4 x = all(y0[q]);
        a[q] += l0 * x;
        b[q] += l1 * x;
        c[q] += l1 * all(y1[q]);
      }
    }
  }
  for (int q = 0; q < 4; ++q) store(t00 + 4 * q, a[q]), store(t10 + 4 * q, b[q]), store(t11 + 4 * q, c[q]);
}

/// H += YᵀY over all rows; Y is made on the way.
template <int R>
inline void add_hessian(GeneralBank<R>& b, const Problem::Rows& rows, const Layout& layout, TileFactor& h) {
  for (const Run& run : b.runs) {
    const auto& support = layout.support(run.support).tiles;
    const int* tiles = support.data();
    const int k = static_cast<int>(support.size());
    scale_rows(b, rows, run, k);
    const double* y = b.Y.data() + run.y;
    const int n = run.end - run.begin, stride = run.stride;
    const auto target = [&](int i, int j) { return h.tile(h.index(tiles[i], tiles[j])); };
    int j = 0;
    for (; j + 2 < k; ++j) {
      const double* right = y + j * R * 4;
      int i = j;
      for (; k - i >= 5 || k - i == 3; i += 3) {
        add_products<R, 3>({target(i, j), target(i + 1, j), target(i + 2, j)}, y + i * R * 4, right, n, stride);
      }
      for (; k - i >= 2; i += 2) add_products<R, 2>({target(i, j), target(i + 1, j)}, y + i * R * 4, right, n, stride);
      if (i < k) add_products<R, 1>({target(i, j)}, y + i * R * 4, right, n, stride);
    }
    if (j + 1 < k)
      add_corner<R>(target(j, j), target(j + 1, j), target(j + 1, j + 1), y + j * R * 4, n, stride);
    else
      add_products<R, 1>({target(j, j)}, y + j * R * 4, y + j * R * 4, n, stride);
  }
}

/// out += Yᵀa for a whole group, a given in its lanes
template <int R>
inline void add_transposed_group(const GeneralBank<R>& b, int g, const V4* a, double* out) {
  const auto row = b.row[static_cast<std::size_t>(4 * g)];
  const double* values = reinterpret_cast<const double*>(a);
  V4 value[R][4];
  for (int r = 0; r < R; ++r) {
    for (int i = 0; i < 4; ++i) value[r][i] = all(values[4 * r + i]);
  }
  const int stride = 4 * R * row.n_tiles;
  const double* y = b.Y.data() + row.y;
  for (int j = 0; j < row.n_tiles; ++j, y += 4 * R) {
    double* to = out + 4 * row.tiles[j];
    V4 acc[R] = {};
    acc[0] = load(to);
    for (int i = 0; i < 4; ++i) {
      for (int r = 0; r < R; ++r) acc[r] += load(y + i * stride + 4 * r) * value[r][i];
    }
    if constexpr (R == 3)
      store(to, acc[0] + (acc[1] + acc[2]));
    else
      store(to, acc[0]);
  }
}

/// out += Yᵀa for one row, a in its lane
template <int R>
inline void add_transposed_row(const GeneralBank<R>& b, int i, const V4* a, double* out) {
  const auto row = b.row[static_cast<std::size_t>(i)];
  const double* value = lane(a, i);
  const double* y = b.Y.data() + row.y;
  for (int j = 0; j < row.n_tiles; ++j, y += 4 * R) {
    double* to = out + 4 * row.tiles[j];
    V4 acc = load(to);
    for (int r = 0; r < R; ++r) acc += load(y + 4 * r) * value[4 * r];
    store(to, acc);
  }
}

/// out += Yᵀa over all rows, `member` gives a of a group
template <int R, class Member>
inline void add_transposed(const GeneralBank<R>& b, Member&& member, double* out) {
  for (int g = 0; g < b.whole_groups; ++g) add_transposed_group<R>(b, g, member(b.group[static_cast<std::size_t>(g)]), out);
  for (int i = 4 * b.whole_groups; i < b.n; ++i) add_transposed_row<R>(b, i, member(b.of(i)), out);
}

/// Y·d of the four rows of a group
template <int R>
inline Element<R> multiply_group(const GeneralBank<R>& b, int g, const double* d) {
  V4 acc[R][4] = {};
  if (g < b.whole_groups) {
    const auto row = b.row[static_cast<std::size_t>(4 * g)];
    const int stride = 4 * R * row.n_tiles;
    const double* y = b.Y.data() + row.y;
    for (int j = 0; j < row.n_tiles; ++j, y += 4 * R) {
      const V4 x = load(d + 4 * row.tiles[j]);
      for (int i = 0; i < 4; ++i) {
        for (int r = 0; r < R; ++r) acc[r][i] += load(y + i * stride + 4 * r) * x;
      }
    }
  } else {
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) {
      if (4 * g + i >= b.n) break;
      const auto row = b.row[static_cast<std::size_t>(4 * g + i)];
      const double* y = b.Y.data() + row.y;
      V4 a[R] = {};
      for (int j = 0; j < row.n_tiles; ++j, y += 4 * R) {
        const V4 x = load(d + 4 * row.tiles[j]);
        for (int r = 0; r < R; ++r) a[r] += load(y + 4 * r) * x;
      }
      for (int r = 0; r < R; ++r) acc[r][i] = a[r];
    }
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

/// G·x of the four rows of a group, raw data.
template <int R>
inline Element<R> multiply_raw_group(const GeneralBank<R>& b, const Problem::Rows& rows, int g, const double* x) {
  V4 acc[R][4] = {};
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {
    if (4 * g + i >= b.n) break;
    const auto row = b.row[static_cast<std::size_t>(4 * g + i)];
    const double* from = rows.G.data() + b.g_offset[static_cast<std::size_t>(4 * g + i)];
    V4 a[R] = {};
    for (int j = 0; j < row.n_tiles; ++j, from += 4 * R) {
      const V4 y = load(x + 4 * row.tiles[j]);
      for (int r = 0; r < R; ++r) a[r] += load(from + 4 * r) * y;
    }
    for (int r = 0; r < R; ++r) acc[r][i] = a[r];
  }
  Element<R> u;
  for (int r = 0; r < R; ++r) u.e[r] = sums(acc[r][0], acc[r][1], acc[r][2], acc[r][3]);
  return u;
}

/// out += Gᵀz and size += |G|ᵀ|z| of sorted row i, raw data.
template <int R>
inline void add_transposed_raw(const GeneralBank<R>& b, const Problem::Rows& rows, int i, double* out, double* size) {
  const auto row = b.row[static_cast<std::size_t>(i)];
  const double* from = rows.G.data() + b.g_offset[static_cast<std::size_t>(i)];
  const double* z = lane(b.of(i).z, i);
  V4 value[R];
  for (int r = 0; r < R; ++r) value[r] = all(z[4 * r]);
  for (int j = 0; j < row.n_tiles; ++j, from += 4 * R) {
    const int t = 4 * row.tiles[j];
    V4 o = load(out + t), a = load(size + t);
    for (int r = 0; r < R; ++r) {
      const V4 term = load(from + 4 * r) * value[r];
      o += term;
      a += abs(term);
    }
    store(out + t, o);
    store(size + t, a);
  }
}

}  // namespace stiction::cone::detail
