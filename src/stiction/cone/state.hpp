#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "stiction/cone/aligned.hpp"
#include "stiction/cone/problem.hpp"
#include "stiction/cone/solver.hpp"
#include "stiction/cone/tile_factor.hpp"

namespace stiction::cone::detail {

/// Iterates of all rows of one kind, R components each, as structure of arrays in groups of four rows: entry (row i, component r)
/// lies at [(i/4)·R + r]·4 + i%4. Rows are sorted by support; `order` maps to the order of adding. Lanes beyond n hold
/// w = z = e, have live = 0 and take no part in anything.
template <int R>
struct Bank {
  static constexpr int kScaling = R == 3 ? 6 : 1;   // entries of the symmetric V = W⁻¹
  int n = 0;
  int groups = 0;
  std::vector<int> order;
  AlignedVector w, z, z_saved, lambda, u, s, c, p, r_p;   // R components
  AlignedVector v;                                        // kScaling components: 00 01 02 11 12 22
  AlignedVector ratio, inv_det, inv_lambda0, weight, inv_weight, live;   // one

  void resize(int rows);
};

/// A run of consecutive rows with the same support.
struct Run {
  int support;
  int begin;
  int end;
  int y;        // doubles before the first row in Y
  int stride;   // doubles per row
};

/// A bank whose rows have a general G.
template <int R>
struct GeneralBank : Bank<R> {
  std::vector<Run> runs;
  struct Row {
    const int* tiles;   // of its support
    int n_tiles;
    int y;              // into Y
  };
  std::vector<Row> row;                       // by sorted row
  std::vector<int> g_offset;                  // by sorted row, into Problem::Rows::G
  std::vector<int> count;                     // scratch of the sort by support
  AlignedVector Y;                            // VG, as Problem::Rows::G
};

/// What is kept of a solve for the next one.
struct Memory {
  struct Rows {
    std::vector<std::uint64_t> id;
    std::vector<double> z;
    int n = 0;
    /// First row with this id, looked for from `hint` on, cyclically; −1 if none.
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
  std::vector<std::uint64_t> below;
  GeneralBank<3> cones;
  GeneralBank<1> lines;
  Bank<1> bounds;
  std::vector<int> bound_slot;     // index of the bound → place in the bank (group · 4 + lane)
  std::vector<int> bound_tile;     // by group
  AlignedVector bound_sign;        // as the bank, 0 at dead lanes
  AlignedVector x, dx, gradient, scratch, scale;   // padded
  Memory memory;
  AlignedVector x_memory;
  bool has_factor = false;
  int n_cones = 0, n_lines = 0, n_bounds = 0;      // of the last solve
  std::vector<int> cone_place, line_place;         // order of adding → sorted row
};

}  // namespace stiction::cone::detail
