#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stiction/core/status.hpp"
#include "stiction/dynamics/rollout.hpp"
#include "stiction/world/model.hpp"

namespace stiction::planning {

/// Bounds on coordinates of the objects: x y z [m] and roll pitch yaw [rad] of a free object, R = Rz(yaw)Ry(pitch)Rx(roll), and the joint
/// coordinates of any other object. −∞ and ∞ mean no bound. Bounds of angles are taken modulo 2π, except those of hinges.
struct GoalRegion {
  Eigen::VectorXd lower, upper;  ///< (n_vu), in the order of the objects' tangent
};

/// Objects that must stay near the place where they stand, on the whole way to the goal.
struct Bystanders {
  std::vector<int> objects;  ///< indices of the objects, ascending
  Eigen::VectorXd q_u;       ///< configuration of all objects where the bystanders stand (n_qu)
  double may_move = 0;       ///< limit on the displacement of each body origin [m] > 0; ∞: no limit
  double may_tip = 0;        ///< limit on the tilt of the axis that points up at q_u [rad] > 0; ∞: no limit
};

/// Where objects should go, with which tolerances.
struct Goal {
  int object = 0;                                   ///< index of the object; the smallest index if the goal has several objects
  world::Pose X_WG;                                 ///< goal pose of the body frame; with a region, one pose inside it
  double tol_position = 0.01;                       ///< [m] > 0
  double tol_angle = 0.1;                           ///< [rad] > 0
  std::optional<GoalRegion> region = std::nullopt;  ///< every pose in it reaches the goal; with several objects it bounds each of them
  std::optional<Bystanders> bystanders = std::nullopt;
};

/// The object and its carriers, which are the objects that its joints attach it to, from the world outwards.
std::vector<int> chain_of(const world::Model& model, int object);

/// The object of the goal and every other object that the region bounds, except objects that carry another one of them; ascending.
std::vector<int> goal_objects(const world::Model& model, const Goal& goal);

/// Motion of a bystander away from the place where it stood.
struct BystanderMotion {
  double move = 0;  ///< displacement of the origin of its body frame [m]
  double tip = 0;   ///< tilt of the axis that pointed up [rad]; 0 without gravity
};
BystanderMotion calc_motion(const world::Model& model, const Bystanders& bystanders, int object, dynamics::VectorRef q);
/// Largest motion of a bystander, as a share of its limit; 0 without bystanders.
double bystander_share(const world::Model& model, const Goal& goal, dynamics::VectorRef q);

/// Roll, pitch and yaw of R = Rz(yaw)Ry(pitch)Rx(roll), pitch in [−π/2, π/2].
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R);

/// Moves the objects at q_u into the region, each coordinate by as little as possible. A rotation has two triples of roll, pitch and yaw;
/// the triple that needs the smaller turn is taken.
/// @param q_u  configuration of the objects (n_qu), changed in place
void project(const world::Model& model, const GoalRegion& region, Eigen::Ref<Eigen::VectorXd> q_u);

/// Distance of an object's pose from the goal pose, or from its projection on the goal region. With several objects, the largest distance.
struct GoalError {
  double position = 0;  ///< [m]
  double angle = 0;     ///< [rad], geodesic
  /// The larger error, in tolerances of the goal.
  double share(const Goal& goal) const { return std::max(position / goal.tol_position, angle / goal.tol_angle); }
  bool within(const Goal& goal) const { return position <= goal.tol_position && angle <= goal.tol_angle; }
};
GoalError goal_error(const world::Model& model, dynamics::VectorRef q, const Goal& goal);

/// Distances from a path that count as one tolerance: the tolerances of the goal. If the goal leaves the rotation of its objects free, an
/// angle counts by how far it moves the surface of the object; the rotation of a ball does not count.
struct PathTolerances {
  double position = 0;  ///< [m]
  double angle = 0;     ///< [rad]
};
PathTolerances path_tolerances(const world::Model& model, const Goal& goal);

/// 1/PathTolerances per coordinate of the objects (n_vu) [1/m or 1/rad].
Eigen::VectorXd inverse_tolerances(const world::Model& model, const Goal& goal);

enum class SegmentKind {
  Settle,   ///< motion from the given start until the objects rest on the constraints (first segment only)
  Contact,  ///< an extension: the robot pushes
  Regrasp,  ///< the robot moves to new contacts while the object rests
};

/// A part of a plan: the sub-steps that the planner simulated.
struct Segment {
  SegmentKind kind = SegmentKind::Contact;
  std::vector<dynamics::Knot> knots;
  /// An unstable regrasp: while branches are away, an object would move if gravity were tilted by threshold::kReleaseTilt. A last resort.
  bool unstable = false;
};

/// Cost of a path [s]: the time of its commands if every joint moves at its speed, plus a price for each regrasp.
struct PathCost {
  double joint_speed = 0.5;   ///< speed of revolute joints [rad/s] > 0
  double travel_speed = 0.1;  ///< speed of sliding joints [m/s] > 0
  double regrasp = 2.0;       ///< price of a regrasp [s] ≥ 0
  void validate() const;
};

/// Commands and predicted states from the start to the goal or near it. Consecutive knots are one sub-step apart.
struct Plan {
  Eigen::VectorXd q_start;  ///< start as given, before any projection (n_q)
  Eigen::VectorXd u_start;  ///< command at the start (n_a)
  std::vector<Segment> segments;
  Goal goal;
  GoalError error;             ///< distance from the goal at the last knot
  dynamics::StepOptions step;  ///< options of the dynamics of every sub-step
  dynamics::SubstepLimits substep;
};

/// Time of one command: max_j |to − from|_j / speed_j [s].
double command_time(const world::Model& model, const Eigen::VectorXd& from, const Eigen::VectorXd& to, const PathCost& cost);

/// Cost of a plan: Σ_k max_j |u_k − u_{k−1}|_j / speed_j + price · (number of regrasps) [s], over all knots k.
double path_cost(const world::Model& model, const Plan& plan, const PathCost& cost);

}  // namespace stiction::planning
