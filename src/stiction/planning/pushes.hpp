#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "stiction/planning/goal_measure.hpp"

namespace stiction::planning {

/// Contact edges between two regrasps, with the state and command from which they start.
struct Push {
  Eigen::VectorXd q_entry, u_entry;
  std::vector<Segment> edges;
  std::optional<Segment> regrasp;  ///< that led to it; none before the first one of a plan that starts with a push
  Eigen::VectorXd u_regrasp;       ///< command from which that started
  bool merged = false;             ///< a push before it was dropped, so that `regrasp` starts elsewhere
};

/// A plan as the list of its pushes; a regrasp at its end serves nothing.
std::vector<Push> split_at_regrasps(const Plan& plan);

/// What counts as a motion of the objects.
struct Motion {
  const GoalMeasure& objects;
  double position, angle;  ///< that count as none [m, rad]
  /// Worst displacement of an object between two configurations, as a share of what counts as none.
  double share(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1) const { return objects.share(q0, q1, position, angle); }
};

/// 3.4.5 (ii): what follows the last motion of the objects is dropped.
void cut_tails(const Motion& motion, std::vector<Push>& pushes);

/// 3.4.5 (i): of contact samples with nothing moved between them only the last counts. A list in which nothing moves stays as it is.
void drop_pushes(const Motion& motion, std::vector<Push>& pushes);

}  // namespace stiction::planning
