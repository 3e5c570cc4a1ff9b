#pragma once

#include "stiction/planning/expansion.hpp"

namespace stiction::planning {

/// SampleSubgoal of Algorithm 2: where the objects are wanted, and whether a push or a change of contacts is to bring them there.
class SubgoalSampler {
 public:
  SubgoalSampler(const PlannerOptions& options, const GoalMeasure& goal) : options_(options), goal_(goal) {}

  /// For subgoals that are the goal also Nearest: first each node is taken there once, by its metric, then those near the goal again.
  Expansion draw(Tree& tree, long iteration) const;

 private:
  const PlannerOptions& options_;
  const GoalMeasure& goal_;
};

}  // namespace stiction::planning
