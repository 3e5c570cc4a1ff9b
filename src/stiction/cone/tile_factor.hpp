#pragma once

#include <cstdint>
#include <vector>

#include "stiction/cone/aligned.hpp"
#include "stiction/cone/layout.hpp"
#include "stiction/cone/tile_mask.hpp"

namespace stiction::cone::detail {

/// Cholesky factor of a symmetric positive definite matrix of 4×4 tiles, H = LLᵀ, computed in place of H.
///
/// analyse() lays out the lower tiles that can be non-zero (fill included), column after column; the caller writes H into
/// values() through index(row, column); factorise() replaces it by L with the inverses of the diagonal tiles. Tiles are
/// column-major. All sizes are those of the constructor: no heap use later.
class TileFactor {
 public:
  explicit TileFactor(int tiles);

  /// @param below  below[j]: the i > j for which tile (i,j) of H may be non-zero. Cheap when equal to the previous call.
  /// @returns whether the tiles have moved
  bool analyse(const std::vector<TileMask>& below);

  int index(int row, int column) const { return index_[static_cast<std::size_t>(row * n_ + column)]; }  ///< −1: always zero
  int n_tiles_stored() const { return n_stored_; }
  double* tile(int i) { return values_.data() + 16 * i; }
  const double* tile(int i) const { return values_.data() + 16 * i; }

  /// Factorises and does the first half of solve(x) on the way. @returns false when a pivot is not positive (or not a number)
  bool factorise(double* x);
  /// The second half of solve().
  void solve_backward(double* x) const;

  /// x ← H⁻¹x, 4·tiles numbers.
  void solve(double* x) const;
  /// The same for four right-hand sides: x is [4·tiles][4], one row per variable. Rows of tiles before `first` are zero.
  void solve4(double* x, int first) const;

 private:
  void plan();
  std::uint32_t offset(int row, int column) const { return static_cast<std::uint32_t>(16 * index(row, column)); }

  struct Target {
    std::uint32_t tile, row;
  };
  /// One to three targets of a column that are updated by the same columns: target m −= Σ tile(aₘ)·tile(b)ᵀ over `count` terms.
  struct Block {
    std::uint32_t target, width, count;
    std::uint32_t first;  // terms_[first + t·(width + 1)] = b, then a of each target
  };
  struct Entry {
    int tile, other;
  };
  int n_;
  int n_stored_ = 0;
  bool analysed_ = false;
  std::vector<TileMask> below_;   // pattern of H at the last analyse()
  std::vector<TileMask> column_;  // pattern of L below the diagonal
  std::vector<TileMask> row_;     // pattern of L left of the diagonal
  std::vector<int> index_;
  std::vector<int> column_start_;  // first target of a column; the first target is the diagonal tile
  std::vector<Target> targets_;
  std::vector<int> block_start_;  // first block of a column
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> terms_;  // offsets into values_
  std::vector<int> row_start_;
  std::vector<Entry> row_entries_;  // tiles left of the diagonal, by row
  AlignedVector values_;
};

}  // namespace stiction::cone::detail
