#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "stiction/cone/cone_least_squares.hpp"
#include "stiction/contact/contact_sampler.hpp"
#include "stiction/planning/regrasp.hpp"
#include "stiction/planning/setting.hpp"
#include "stiction/planning/tree.hpp"

namespace stiction::planning {

/// Memory that one thread needs to grow a tree.
struct ThreadScratch : SimulationScratch {
  ThreadScratch(const std::shared_ptr<const world::Model>& model, const core::RunControl& control)
      : SimulationScratch(model, control), least_squares(model->n_a()) {}

  cone::ConeLeastSquares least_squares;
  Regrasp regrasp;
  Node candidate;
};

/// One expansion of the tree, from the draw of the subgoal to the new nodes.
struct Expansion {
  std::uint64_t stream = 0;
  int near = -1;  ///< node that is expanded; −1: the thread finds it
  bool grasp = false;
  bool at_place = false;  ///< `near` is the node whose objects are nearest to the subgoal, else the nearest by the metric
  bool to_goal = false;
  bool choose = true;             ///< a regrasp chooses among many postures
  bool in_cones = false;          ///< contact forces stay in their friction cones (P.7)
  Eigen::VectorXd subgoal;        ///< qᵘ (n_qu)
  int tool = -1;                  ///< object that the subgoal is about if it is a tool, not an object of the goal; else −1
  std::vector<int> aim;           ///< in scenes with tools: the objects that the subgoal is about; the others may be anywhere
  Eigen::VectorXd counted;        ///< 1 per coordinate that the subgoal is about, else 0 (n_vu)
  std::vector<char> touch;        ///< pairs at which a regrasp may take hold; empty: all
  EdgeReplay near_replay;         ///< replay of `near`, if this expansion computed it
  int refined = -1;               ///< node to which near_replay belongs
  bool rejected = false;          ///< `near` failed its verification: nothing is built on it
  bool may_be_unstable = false;   ///< a release may be unstable, because hardly any release is stable
  Release release;                ///< branches that a regrasp releases
  bool release_unstable = false;  ///< these branches leave the object at `near` unstable when they let go
  Eigen::VectorXd command;        ///< command to which `near` was extended (n_a); empty: none
  std::vector<Node> chain;        ///< new nodes, each the parent of the next
  int broken = 0;                 ///< number of edges rejected at the end of the chain
  Totals totals;

  /// Where the objects should go from q_u: to the subgoal, or to the nearest place in a goal region.
  Eigen::VectorXd target(const GoalMeasure& goal, const Eigen::VectorXd& q_u) const {
    if (to_goal) return goal.nearest_to(q_u);
    return aim.empty() ? subgoal : goal.with(aim, subgoal, q_u);
  }
  /// Distance of the objects from target(), in tolerances of the goal.
  double distance(const GoalMeasure& goal, const Eigen::VectorXd& q) const {
    return goal.distance(q, target(goal, q.head(subgoal.size())));
  }
};

}  // namespace stiction::planning
