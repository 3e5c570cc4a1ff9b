#pragma once

#include <Eigen/Core>

#include "stiction/planning/planner.hpp"
#include "stiction/world/object_space.hpp"

namespace stiction::planning {

/// How far objects are from the goal, and from each other's places, in tolerances of the goal.
class GoalMeasure {
 public:
  explicit GoalMeasure(const PlanningProblem& problem);

  const world::ObjectSpace& space() const { return space_; }
  int object() const { return goal_.object; }
  const std::vector<int>& objects() const { return objects_; }  ///< of the goal (goal_objects)
  /// Those of them that robots cannot touch, and so move with others: where there are such, the goal is not about the others, which may go anywhere.
  const std::vector<int>& out_of_touch() const { return out_of_touch_; }
  const Eigen::VectorXd& q_goal() const { return q_goal_; }  ///< qᵘ of the goal (n_qu)

  /// Of a goal region the place nearest to q_u, else that of the goal (n_qu).
  Eigen::VectorXd nearest_to(const Eigen::VectorXd& q_u) const;
  /// Worst of position and angle error of the goal's objects, divided by the tolerance.
  double ratio(const Eigen::VectorXd& q) const;
  /// The objects at q_u, but the given ones as they are at q_there (n_qu).
  Eigen::VectorXd with(const std::vector<int>& objects, const Eigen::VectorXd& q_there, Eigen::VectorXd q_u) const;
  /// 1 per coordinate of the given objects and of those that they hang on, else 0 (n_vu).
  Eigen::VectorXd flags(const std::vector<int>& objects) const;
  /// Of all coordinates, so that an object that is turned first and brought back later gets nearer all the time.
  double distance(const Eigen::VectorXd& q, const Eigen::VectorXd& q_u) const;
  double distance(const Eigen::VectorXd& q) const { return distance(q, nearest_to(q.head(model_.n_qu()))); }
  /// to ⊖ from, of the objects (n_vu).
  Eigen::VectorXd difference(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;
  /// Worst displacement of an object between two configurations, as a share of the given distance [m] and angle [rad] …
  double share(const Eigen::VectorXd& from, const Eigen::VectorXd& to, double position, double angle) const;
  /// … or of the tolerances of the path.
  double share_of_tolerances(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
    return share(from, to, tolerances_.position, tolerances_.angle);
  }
  const PathTolerances& tolerances() const { return tolerances_; }
  /// 1/tolerance per coordinate of the objects (n_vu).
  const Eigen::VectorXd& inverse_tolerances() const { return inverse_tolerances_; }
  /// The same with 1 for positions: the length that an angle counts for (n_vu) [m/rad].
  Eigen::VectorXd lengths() const { return tolerances_.position * inverse_tolerances_; }
  /// 1 per coordinate that the goal is about, else 0: what a goal region bounds; all without one (n_vu).
  const Eigen::VectorXd& bounded() const { return bounded_; }

 private:
  const world::Model& model_;
  const Goal& goal_;
  world::ObjectSpace space_;
  std::vector<int> objects_, out_of_touch_;
  PathTolerances tolerances_;
  Eigen::VectorXd q_goal_, inverse_tolerances_, bounded_;
};

/// qᵘ of the goal: as given, or from the pose of its object (n_qu).
Eigen::VectorXd goal_configuration(const PlanningProblem& problem, const world::ObjectSpace& space);

}  // namespace stiction::planning
