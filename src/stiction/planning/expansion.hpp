#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "stiction/cone/cone_least_squares.hpp"
#include "stiction/planning/contact_sampler.hpp"
#include "stiction/planning/goal_measure.hpp"
#include "stiction/planning/regrasp.hpp"
#include "stiction/planning/tree.hpp"

namespace stiction::planning {

inline RegraspCounts& operator+=(RegraspCounts& sum, const RegraspCounts& o) {
  sum.tried += o.tried;
  sum.accepted += o.accepted;
  sum.no_sample += o.no_sample;
  sum.no_path += o.no_path;
  sum.object_moved += o.object_moved;
  sum.failed_step += o.failed_step;
  return sum;
}

struct Totals {
  long steps = 0, linearisations = 0, failed_steps = 0, distrusted = 0;
  RegraspCounts regrasps;

  Totals& operator+=(const Totals& o) {
    steps += o.steps;
    linearisations += o.linearisations;
    failed_steps += o.failed_steps;
    distrusted += o.distrusted;
    regrasps += o.regrasps;
    return *this;
  }
};

/// Everything one thread needs.
struct ThreadScratch {
  ThreadScratch(const std::shared_ptr<const world::Model>& model, const core::RunControl& control)
      : steps(model), locals(model), geometry(*model), least_squares(model->n_a()) {
    geometry.control = &control;
  }
  bool stop() const { return geometry.stop(); }

  dynamics::StepWorkspace steps;
  dynamics::LocalModelWorkspace locals;
  GeometryWorkspace geometry;
  cone::ConeLeastSquares least_squares;
  dynamics::StepResult step_result;
  dynamics::RolloutResult rollout_result;
  dynamics::LocalModel local;
  Regrasp regrasp;
  Node candidate;
};

/// One growth of the tree, from the draw of the subgoal to the new nodes.
struct Expansion {
  std::uint64_t stream = 0;
  int near = -1;  ///< −1: to be found by the thread
  bool grasp = false;
  bool to_goal = false;
  bool by_place = false;        ///< near by the place of the objects, whatever the posture
  bool in_cones = false;        ///< contact forces stay in their cones (P.7)
  Eigen::VectorXd subgoal;      ///< qᵘ (n_qu)
  EdgeReplay near_replay;       ///< of `near`, when this expansion computed it
  int refined = -1;             ///< the node that it belongs to
  bool rejected = false;        ///< it is too far from q to build on; the chain then is what is left of the node's edge
  GraspDraw draw;               ///< of a regrasp
  bool release_failed = false;  ///< its branches cannot let go of the object at `near`
  int cannot_release = -1;      ///< a node at which no branches can
  Eigen::VectorXd command;      ///< that `near` was extended to (n_a); empty: it was not
  std::vector<Node> chain;      ///< new nodes, each the parent of the next
  std::size_t taken = 0;        ///< so many of them were extended towards the subgoal already
  int broken = 0;               ///< edges given up at the end of the chain
  Totals totals;

  /// Where the objects are wanted when they are at q_u: the subgoal, or of a goal region the nearest place.
  Eigen::VectorXd target(const GoalMeasure& goal, const Eigen::VectorXd& q_u) const { return to_goal ? goal.nearest_to(q_u) : subgoal; }
  /// From there, in tolerances of the goal.
  double distance(const GoalMeasure& goal, const Eigen::VectorXd& q) const {
    return goal.distance(q, target(goal, q.head(subgoal.size())));
  }
};

}  // namespace stiction::planning
