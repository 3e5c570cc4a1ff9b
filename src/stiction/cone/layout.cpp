#include "stiction/cone/layout.hpp"

#include <algorithm>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::cone {
namespace {

/// First lane of a group that starts at or after `next` and touches no more tiles than its size needs.
int place(int next, int size) {
  const int needed = (size + kTile - 1) / kTile;
  const int touched = (next + size - 1) / kTile - next / kTile + 1;
  return touched > needed ? (next + kTile - 1) / kTile * kTile : next;
}

}  // namespace

Layout::Layout(int n, const std::vector<std::vector<int>>& groups)
    : n_(n), position_(static_cast<std::size_t>(std::max(n, 0)), -1), group_(static_cast<std::size_t>(std::max(n, 0)), -1) {
  if (n < 1) core::throw_invalid("n", std::to_string(n), "at least one variable");
  int next = 0;
  int n_placed = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].empty()) continue;
    next = place(next, static_cast<int>(groups[g].size()));
    for (const int variable : groups[g]) {
      if (variable < 0 || variable >= n) core::throw_invalid("groups", std::to_string(variable), "a variable in 0 … n−1");
      auto& position = position_[static_cast<std::size_t>(variable)];
      if (position >= 0) core::throw_invalid("groups", "variable " + std::to_string(variable) + " twice", "each variable once");
      position = next++;
      group_[static_cast<std::size_t>(variable)] = static_cast<int>(g);
      ++n_placed;
    }
  }
  if (n_placed != n) core::throw_invalid("groups", std::to_string(n_placed) + " variables", std::to_string(n) + " variables");
  n_tiles_ = (next + kTile - 1) / kTile;
  if (n_tiles_ > kMaxTiles)
    core::throw_invalid("groups", std::to_string(n_tiles_) + " tiles", "at most " + std::to_string(kMaxTiles) + " tiles of 4 variables");

  q_index_.assign(static_cast<std::size_t>(n_tiles_ * n_tiles_), -1);
  const auto add_tile = [this](int row, int column) {
    int& index = q_index_[static_cast<std::size_t>(row * n_tiles_ + column)];
    if (index >= 0) return;
    index = static_cast<int>(q_tiles_.size());
    q_tiles_.push_back({row, column});
  };
  for (int t = 0; t < n_tiles_; ++t) add_tile(t, t);
  for (const auto& members : groups) {
    for (const int i : members) {
      for (const int j : members) {
        if (tile(i) > tile(j)) add_tile(tile(i), tile(j));
      }
    }
  }
}

int Layout::add_support(std::span<const int> variables) {
  if (variables.empty()) core::throw_invalid("variables", "an empty set", "at least one variable");
  for (std::size_t s = 0; s < supports_.size(); ++s) {
    if (std::ranges::equal(supports_[s].variables, variables)) return static_cast<int>(s);
  }
  Support support;
  for (const int variable : variables) {
    if (variable < 0 || variable >= n_) core::throw_invalid("variables", std::to_string(variable), "a variable in 0 … n−1");
    if (std::ranges::find(support.variables, variable) != support.variables.end()) {
      core::throw_invalid("variables", "variable " + std::to_string(variable) + " twice", "distinct variables");
    }
    support.variables.push_back(variable);
    support.tiles.push_back(tile(variable));
  }
  std::ranges::sort(support.tiles);
  support.tiles.erase(std::unique(support.tiles.begin(), support.tiles.end()), support.tiles.end());
  for (const int variable : variables) {
    const auto at = std::ranges::find(support.tiles, tile(variable));
    support.slot.push_back(static_cast<int>(at - support.tiles.begin()));
    support.lane.push_back(lane(variable));
  }
  supports_.push_back(std::move(support));
  return static_cast<int>(supports_.size()) - 1;
}

}  // namespace stiction::cone
