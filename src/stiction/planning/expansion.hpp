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

/// Everything one thread needs to grow a tree.
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
  int near = -1;  ///< −1: to be found by the thread
  bool grasp = false;
  bool at_place = false;  ///< it starts where the objects are nearest to the subgoal, else by the metric
  bool to_goal = false;
  bool choose = true;             ///< a regrasp chooses among many postures
  bool in_cones = false;          ///< contact forces stay in their cones (P.7)
  Eigen::VectorXd subgoal;        ///< qᵘ (n_qu)
  int tool = -1;                  ///< the subgoal is of this object, which is not of the goal
  std::vector<int> aim;           ///< where there are such: the objects that it is about; the others may go anywhere
  Eigen::VectorXd counted;        ///< 1 per coordinate that it is about, else 0 (n_vu)
  std::vector<char> touch;        ///< pairs at which a regrasp may take hold; empty: any
  EdgeReplay near_replay;         ///< of `near`, when this expansion computed it
  int refined = -1;               ///< the node that it belongs to
  bool rejected = false;          ///< it is too far from q to build on
  bool may_be_unstable = false;   ///< a release, since hardly any is stable
  Release release;                ///< of a regrasp
  bool release_unstable = false;  ///< its branches cannot let go of the object at `near` without leaving it unstable
  Eigen::VectorXd command;        ///< that `near` was extended to (n_a); empty: it was not
  std::vector<Node> chain;        ///< new nodes, each the parent of the next
  int broken = 0;                 ///< edges given up at the end of the chain
  Totals totals;

  /// Where the objects are wanted when they are at q_u: the subgoal, or of a goal region the nearest place.
  Eigen::VectorXd target(const GoalMeasure& goal, const Eigen::VectorXd& q_u) const {
    if (to_goal) return goal.nearest_to(q_u);
    return aim.empty() ? subgoal : goal.with(aim, subgoal, q_u);
  }
  /// From there, in tolerances of the goal.
  double distance(const GoalMeasure& goal, const Eigen::VectorXd& q) const {
    return goal.distance(q, target(goal, q.head(subgoal.size())));
  }
};

}  // namespace stiction::planning
