#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// A set of branches of the robots, one bit per branch.
using ChainMask = std::uint64_t;

/// The branches (fingers, arms, trunks) of all robots and the pairs that each of them moves.
class RobotChains {
 public:
  explicit RobotChains(const Model& model);

  int size() const { return static_cast<int>(joints_.size()); }
  ChainMask all() const { return all_; }

  /// Joints of a branch as indices into u.
  std::span<const int> joints(int chain) const { return joints_[static_cast<std::size_t>(chain)]; }
  /// Number of branches that carry this one: 0 for an arm, and for a finger on a fixed palm.
  int depth(int chain) const { return depth_[static_cast<std::size_t>(chain)]; }
  /// Joints of all branches in the mask, ascending.
  std::vector<int> joints_of(ChainMask mask) const;

  /// Pairs of which the branches in the mask move at least one side.
  void pairs_of(ChainMask mask, std::vector<int>& pairs) const;
  /// Pairs of which this branch moves exactly one side.
  std::span<const int> pairs_against(int chain) const { return against_[static_cast<std::size_t>(chain)]; }

  /// Pairs between an object and a geometry that this branch carries.
  std::span<const int> object_pairs(int chain) const { return object_pairs_[static_cast<std::size_t>(chain)]; }
  bool touches_object(int pair) const { return object_pair_[static_cast<std::size_t>(pair)] != 0; }
  ChainMask mask_of_pair(int pair) const { return pair_mask_[static_cast<std::size_t>(pair)]; }

 private:
  std::vector<std::vector<int>> joints_;
  std::vector<std::vector<int>> object_pairs_, against_;
  std::vector<int> depth_;
  std::vector<ChainMask> pair_mask_;
  std::vector<char> object_pair_;
  ChainMask all_ = 0;
};

}  // namespace stiction::world
