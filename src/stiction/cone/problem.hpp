#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace stiction::cone {

/// Lanes of a tile: variables are stored, eliminated and vectorised four at a time.
inline constexpr int kTile = 4;

/// Where each variable of (C) lives. Built once per model and shared.
///
/// Variables come in groups that couple through Q only inside a group (a finger, an arm, an object's translation, …), listed in
/// elimination order. A row of G touches few variables; each distinct set of variables is registered once as a support, so that
/// adding a row later is a copy.
class Layout {
 public:
  /// @param n       number of variables, ≥ 1
  /// @param groups  each variable 0 … n−1 exactly once, in elimination order
  /// @throws InvalidInput when groups do not partition the variables
  Layout(int n, const std::vector<std::vector<int>>& groups);

  /// Registers the set of variables that a row touches; returns its index (the same set gives the same index).
  /// @param variables  distinct variables; their order is the column order of the dense G handed to Problem::add_*
  int add_support(std::span<const int> variables);

  int size() const { return n_; }
  int tiles() const { return n_tiles_; }
  int tile(int variable) const { return position_[static_cast<std::size_t>(variable)] / kTile; }
  int lane(int variable) const { return position_[static_cast<std::size_t>(variable)] % kTile; }

 private:
  friend class Problem;
  int n_ = 0;
  int n_tiles_ = 0;
  std::vector<int> position_;   // variable → tile · kTile + lane
};

}  // namespace stiction::cone
