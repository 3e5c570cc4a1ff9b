#pragma once

#include "stiction/planning/expansion.hpp"

namespace stiction::planning {

/// SampleSubgoal of Algorithm 2: where the objects are wanted, and whether a push or a change of contacts is to bring them there.
class SubgoalSampler {
 public:
  explicit SubgoalSampler(const Setting& setting) : setting_(setting) {}

  /// For subgoals that are the goal also Nearest: first each node is taken there once, by its metric, then those near the goal again.
  Expansion draw(Tree& tree, long iteration) const;

 private:
  const Setting& setting_;
};

}  // namespace stiction::planning
