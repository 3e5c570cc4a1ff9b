#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "stiction/cone/aligned.hpp"
#include "stiction/cone/problem.hpp"
#include "stiction/cone/simd.hpp"
#include "stiction/cone/solver.hpp"
#include "stiction/cone/tile_factor.hpp"

namespace stiction::cone::detail {

/// Softness of half-lines, w = Gx + g + give·z (eq. 20). Cones have none.
template <int R>
struct Softness {};
template <>
struct Softness<1> {
  V4 give, yield, hold;  // yield = give·V², hold = 1/(1 + yield); a hard row has 0 and 1
};

/// Four rows of one kind with R components each, one row per lane. All data of an iteration for these rows lie side by side.
template <int R>
struct Group : Softness<R> {
  static constexpr int kScaling = R == 3 ? 6 : 1;  // entries of the symmetric V = W⁻¹: 00 01 02 11 12 22
  V4 w[R], z[R], lambda[R], u[R], s[R], c[R], p[R], r_p[R];
  V4 v[kScaling];
  V4 ratio, inv_det, inv_lambda0, weight, inv_weight, live;
  V4 length, inv_work;  // from the Unit of the row; 1 and 0 at lanes without a row
  V4 z_saved[R];
  V4 g[R];   // g of w = Gx + g, shift included; e at lanes without a row
  V4 shift;  // Options::shift_by_tangent: the part of g[0] that the shift adds
};

/// All rows of one kind. Rows are sorted by support; `order` maps to the order of adding. Lanes without a row hold w = z = e,
/// have live = 0 and take no part in anything.
template <int R>
struct Bank {
  int n = 0;
  int groups = 0;
  std::vector<int> order;
  std::vector<Group<R>, AlignedAllocator<Group<R>>> group;

  void resize(int rows);
  Group<R>& of(int row) { return group[static_cast<std::size_t>(row / 4)]; }
  const Group<R>& of(int row) const { return group[static_cast<std::size_t>(row / 4)]; }
};

/// Component 0 of a row in a member of its group; component r is 4·r further on.
inline double* lane(V4* member, int row) { return reinterpret_cast<double*>(member) + row % 4; }
inline const double* lane(const V4* member, int row) { return reinterpret_cast<const double*>(member) + row % 4; }

/// Consecutive rows with the same support: whole groups, or single rows of groups that mix supports.
struct Run {
  int support;
  int begin;
  int end;
  int y;       // doubles before the first row in Y
  int stride;  // doubles per row
};

/// A bank whose rows have a general G. Whole groups of one support come first, then the remaining rows of each support.
template <int R>
struct GeneralBank : Bank<R> {
  std::vector<Run> runs;
  int whole_groups = 0;  // the first groups, each of one support
  struct Row {
    const int* tiles;  // tiles of its support
    int n_tiles;
    int y;  // offset into Y
  };
  std::vector<Row> row;       // by sorted row
  std::vector<int> g_offset;  // by sorted row, into Problem::Rows::G
  struct Places {
    int count, whole, whole_end, rest;
  };
  std::vector<Places> places;  // scratch of the sort by support
  AlignedVector Y;             // VG, as Problem::Rows::G
};

/// Warm-start memory: data of a solve that the next solve may use.
struct Memory {
  struct Rows {
    std::vector<std::uint64_t> id;
    std::vector<double> z;
    int n = 0;
    /// Index of the first row with this id, searched cyclically from `hint` on; −1 if none.
    int find(std::uint64_t wanted, int hint) const;
  };
  bool valid = false;
  Mode mode = Mode::Exact;
  Rows cones, lines, bounds;
};

struct State {
  explicit State(std::shared_ptr<const Layout> layout);

  std::shared_ptr<const Layout> layout;
  TileFactor factor;
  std::vector<TileMask> below;
  std::vector<int> q_of;  // stored tile of the factor → tile of Q, −1 if Q has none
  GeneralBank<3> cones;
  GeneralBank<1> lines;
  Bank<1> bounds;
  bool gives = false;                             // true if any bound is soft (give > 0)
  std::vector<int> bound_slot;                    // index of the bound → place in the bank (group · 4 + lane)
  std::vector<int> bound_tile;                    // tile of each group of bounds
  AlignedVector bound_sign;                       // four per group, 0 at dead lanes
  AlignedVector x, dx, gradient, scratch, scale;  // padded
  Memory memory;
  AlignedVector x_memory;
  bool has_factor = false;
  int n_cones = 0, n_lines = 0, n_bounds = 0;  // row counts of the last solve
  std::vector<int> cone_place, line_place;     // order of adding → sorted row
};

}  // namespace stiction::cone::detail
