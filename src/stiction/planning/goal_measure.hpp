#pragma once

#include <Eigen/Core>

#include "stiction/planning/planner.hpp"
#include "stiction/world/object_space.hpp"

namespace stiction::planning {

/// Distances of objects from the goal, and from other configurations, in tolerances of the goal.
class GoalMeasure {
 public:
  explicit GoalMeasure(const PlanningProblem& problem);

  const world::ObjectSpace& space() const { return space_; }
  int object() const { return goal_.object; }
  const std::vector<int>& objects() const { return objects_; }  ///< objects of the goal (goal_objects)
  /// Objects of the goal that robots cannot touch, so that tools must move them. If there are any, objects not of the goal are free.
  const std::vector<int>& out_of_touch() const { return out_of_touch_; }
  const Eigen::VectorXd& q_goal() const { return q_goal_; }  ///< goal configuration of the objects (n_qu)

  /// The configuration of the goal region that is nearest to q_u; without a region, that of the goal (n_qu).
  Eigen::VectorXd nearest_to(const Eigen::VectorXd& q_u) const;
  /// Larger of the position and angle errors of the goal's objects, in tolerances.
  double ratio(const Eigen::VectorXd& q) const;
  /// The objects at q_u, but the given objects and their carriers as they are at q_there (n_qu).
  Eigen::VectorXd with(const std::vector<int>& objects, const Eigen::VectorXd& q_there, Eigen::VectorXd q_u) const;
  /// 1 per coordinate of the given objects and of their carriers, else 0 (n_vu).
  Eigen::VectorXd flags(const std::vector<int>& objects) const;
  /// Norm over all coordinates, in tolerances: unlike the larger error, it falls all the time if an object is turned first and moved later.
  double distance(const Eigen::VectorXd& q, const Eigen::VectorXd& q_u) const;
  double distance(const Eigen::VectorXd& q) const { return distance(q, nearest_to(q.head(model_.n_qu()))); }
  /// to ⊖ from in the tangent of the objects (n_vu).
  Eigen::VectorXd difference(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;
  /// Largest displacement of an object between two configurations, as a share of the given distance [m] and angle [rad].
  double share(const Eigen::VectorXd& from, const Eigen::VectorXd& to, double position, double angle) const;
  /// Largest displacement of an object, as a share of the tolerances of the path.
  double share_of_tolerances(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
    return share(from, to, tolerances_.position, tolerances_.angle);
  }
  const PathTolerances& tolerances() const { return tolerances_; }
  /// 1/tolerance per coordinate of the objects (n_vu).
  const Eigen::VectorXd& inverse_tolerances() const { return inverse_tolerances_; }
  /// Length that a unit of a coordinate counts for: 1 for positions, [m/rad] for angles (n_vu).
  Eigen::VectorXd lengths() const { return tolerances_.position * inverse_tolerances_; }
  /// 1 per coordinate that counts, else 0 (n_vu): with a region the bounded ones, else all, or with tools those of the goal's objects.
  const Eigen::VectorXd& bounded() const { return bounded_; }

 private:
  const world::Model& model_;
  const Goal& goal_;
  world::ObjectSpace space_;
  std::vector<int> objects_, out_of_touch_;
  PathTolerances tolerances_;
  Eigen::VectorXd q_goal_, inverse_tolerances_, bounded_;
};

/// Goal configuration of the objects, as given or from the goal pose (n_qu).
Eigen::VectorXd goal_configuration(const PlanningProblem& problem, const world::ObjectSpace& space);

}  // namespace stiction::planning
