#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace stiction::cone {

/// Lanes of a tile: variables are stored, eliminated and vectorised four at a time.
inline constexpr int kTile = 4;
/// Largest number of tiles of a layout, a multiple of 64.
inline constexpr int kMaxTiles = 256;

/// Where each variable of (C) lives. Built once per model and shared.
///
/// Variables come in groups that couple through Q only inside a group (a finger, an arm, an object …), listed in elimination
/// order (fingers before objects, objects up the stack before the arm). A row of G touches few variables; each distinct set
/// of variables is registered once as a support, so that adding a row later is a copy.
///
/// Groups are packed lane after lane. A group starts a new tile only if it would otherwise touch more tiles than its size needs.
/// So groups of 6 share tiles in pairs, and groups of 3 and 4 have their own tiles.
class Layout {
 public:
  /// The tiles that a registered set of variables touches.
  struct Support {
    std::vector<int> variables;  ///< in the caller's column order
    std::vector<int> tiles;      ///< increasing
    std::vector<int> slot;       ///< column → index into `tiles`
    std::vector<int> lane;       ///< column → lane
  };

  /// @param n       number of variables, ≥ 1
  /// @param groups  each variable 0 … n−1 exactly once, in elimination order
  /// @throws InvalidInput when groups do not partition the variables, or more than 256 tiles would be needed
  Layout(int n, const std::vector<std::vector<int>>& groups);

  /// Registers the set of variables that a row touches; returns its index (the same list gives the same index).
  /// @param variables  distinct variables; their order is the column order of the dense G handed to Problem::add_*
  /// @throws InvalidInput when empty, out of range or repeated
  int add_support(std::span<const int> variables);

  int size() const { return n_; }
  int tiles() const { return n_tiles_; }
  int padded_size() const { return n_tiles_ * kTile; }
  int position(int variable) const { return position_[static_cast<std::size_t>(variable)]; }  ///< tile · kTile + lane
  int tile(int variable) const { return position(variable) / kTile; }
  int lane(int variable) const { return position(variable) % kTile; }
  int group(int variable) const { return group_[static_cast<std::size_t>(variable)]; }
  int n_supports() const { return static_cast<int>(supports_.size()); }
  const Support& support(int index) const { return supports_[static_cast<std::size_t>(index)]; }

  /// A tile (row ≥ column) in which Q may have entries.
  struct QTile {
    int row;
    int column;
  };
  const std::vector<QTile>& q_tiles() const { return q_tiles_; }
  /// Index of tile (row, column), row ≥ column, in q_tiles(); −1 when Q has nothing there.
  int q_tile(int row, int column) const { return q_index_[static_cast<std::size_t>(row * n_tiles_ + column)]; }

 private:
  int n_ = 0;
  int n_tiles_ = 0;
  std::vector<int> position_;
  std::vector<int> group_;
  std::vector<QTile> q_tiles_;
  std::vector<int> q_index_;
  std::vector<Support> supports_;
};

}  // namespace stiction::cone
