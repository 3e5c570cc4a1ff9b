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
  std::optional<Segment> regrasp;  ///< regrasp that led to the push; none if the plan starts with the push
  Eigen::VectorXd u_regrasp;       ///< command from which that regrasp started
  bool merged = false;             ///< a push before this one was dropped, so that `regrasp` starts elsewhere
};

/// A plan as the list of its pushes. A regrasp at the end is useless and left out.
std::vector<Push> split_at_regrasps(const Plan& plan);

/// Limits that tell motions of the objects from rest.
struct Motion {
  const GoalMeasure& objects;
  double position, angle;  ///< smaller displacements count as none [m, rad]
  /// Largest displacement of an object between two configurations, as a share of these limits.
  double share(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1) const { return objects.share(q0, q1, position, angle); }
};

/// 3.4.5 (ii): cuts the commands of each push after the last motion of the objects.
void cut_tails(const Motion& motion, std::vector<Push>& pushes);

/// 3.4.5 (i): drops pushes that move nothing, so that the last of several contact samples counts. If nothing moves at all, the list stays.
void drop_pushes(const Motion& motion, std::vector<Push>& pushes);

}  // namespace stiction::planning
