#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "stiction/core/status.hpp"
#include "stiction/dynamics/rollout.hpp"
#include "stiction/world/model.hpp"

namespace stiction::planning {

/// Where one object should go, and how near is near enough.
struct Goal {
  int object = 0;              ///< index of the object
  world::Pose X_WG;            ///< goal pose of its body frame
  double tol_position = 0.01;  ///< [m] > 0
  double tol_angle = 0.1;      ///< [rad] > 0
};

/// Distance of an object pose from a goal.
struct GoalError {
  double position = 0;  ///< [m]
  double angle = 0;     ///< [rad], geodesic
  bool within(const Goal& goal) const { return position <= goal.tol_position && angle <= goal.tol_angle; }
};
GoalError goal_error(const world::Model& model, dynamics::VectorRef q, const Goal& goal);

enum class SegmentKind {
  Settle,   ///< from the given start to rest on the constraints (first segment only)
  Contact,  ///< an extension: the robot pushes
  Regrasp,  ///< the robot moves to new contacts while the object rests
};

/// A piece of a plan: the sub-steps that the planner simulated.
struct Segment {
  SegmentKind kind = SegmentKind::Contact;
  std::vector<dynamics::Knot> knots;
};

/// Commands and predicted states from the start to (near) the goal. Consecutive knots are one sub-step apart.
struct Plan {
  Eigen::VectorXd q_start;  ///< as given, before any projection (n_q)
  Eigen::VectorXd u_start;  ///< command at the start (n_a)
  std::vector<Segment> segments;
  Goal goal;
  GoalError error;             ///< at the last knot
  dynamics::StepOptions step;  ///< dynamics of every sub-step
  dynamics::SubstepLimits substep;
};

}  // namespace stiction::planning
