#pragma once

#include <functional>

#include "stiction/planning/plan_from.hpp"

namespace stiction::planning {

/// Nodes that a tree gained since it was last told of.
struct Growth {
  int tree = 0;              ///< of the run, counted from 0: trees grow side by side, and one that stalls makes room for the next
  int first = 0;             ///< number of the first of these nodes in their tree
  std::vector<int> parents;  ///< numbers of nodes in the tree, -1 of the root
  Eigen::MatrixXd q;         ///< (n_q × nodes) [m, rad]
  int best = -1;             ///< node of the tree that is nearest the goal
  double best_ratio = 0;     ///< how far that one is, in tolerances
};
using GrowthSink = std::function<void(const Growth&)>;

/// plan_from(), told between rounds how its trees grow, by the thread that called it. Trees that look for a cheaper path (anytime) are not told of.
/// Every node of the tree whose path is the plan is told of once; the plan is that of plan_from(), to the last bit.
/// @param u_start  commands at the start (n_a) [rad or m]; empty: joints are commanded where they are
/// @throws core::InvalidInput, as plan_from()
core::Status plan_watched(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                          const core::RunControl& control, const GrowthSink& grown, PlanResult& result);

}  // namespace stiction::planning
