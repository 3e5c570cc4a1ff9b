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

/// Bounds on coordinates of the objects: x y z [m] and roll pitch yaw [rad], R = Rz(yaw)Ry(pitch)Rx(roll), of a free one, the coordinates of
/// any other. −∞ and ∞: any value. Bounds of angles are taken modulo 2π, except those of hinges.
struct GoalRegion {
  Eigen::VectorXd lower, upper;  ///< (n_vu), in the order of the objects' tangent
};

/// Objects that are not to go far from where they stand, on the whole way to the goal.
struct Bystanders {
  std::vector<int> objects;  ///< ascending
  Eigen::VectorXd q_u;       ///< where they stand (n_qu)
  double may_move = 0;       ///< of the origins of their frames [m] > 0; ∞: as far as they like
  double may_tip = 0;        ///< of what points up in them where they stand [rad] > 0; ∞: as far as they like
};

/// Where objects should go, and how near is near enough.
struct Goal {
  int object = 0;                                   ///< index of the object; of several the smallest one
  world::Pose X_WG;                                 ///< goal pose of its body frame; one of those in the region, when there is one
  double tol_position = 0.01;                       ///< [m] > 0
  double tol_angle = 0.1;                           ///< [rad] > 0
  std::optional<GoalRegion> region = std::nullopt;  ///< every pose in it will do; of several objects it bounds each
  std::optional<Bystanders> bystanders = std::nullopt;
};

/// The object and those that it hangs on, from the world outwards.
std::vector<int> chain_of(const world::Model& model, int object);

/// The object of the goal, and every other one that its region bounds, without those that another of them hangs on; ascending.
std::vector<int> goal_objects(const world::Model& model, const Goal& goal);

/// How far a bystander is from where it stood: its origin, and what pointed up in it.
struct BystanderMotion {
  double move = 0;  ///< [m]
  double tip = 0;   ///< [rad]; 0 without gravity
};
BystanderMotion calc_motion(const world::Model& model, const Bystanders& bystanders, int object, dynamics::VectorRef q);
/// The largest motion of a bystander, as a share of what it may; 0 without any.
double bystander_share(const world::Model& model, const Goal& goal, dynamics::VectorRef q);

/// Roll, pitch and yaw of R = Rz(yaw)Ry(pitch)Rx(roll), pitch in [−π/2, π/2].
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R);

/// The objects at q, moved into the region by as little as each coordinate needs. Of the two triples of roll, pitch and yaw of a rotation the
/// one that has to turn less is taken.
/// @param q_u  configuration of the objects (n_qu), changed in place
void project(const world::Model& model, const GoalRegion& region, Eigen::Ref<Eigen::VectorXd> q_u);

/// Distance of an object pose from a goal, or from its projection on the region of the goal; of several objects the farthest one.
struct GoalError {
  double position = 0;  ///< [m]
  double angle = 0;     ///< [rad], geodesic
  /// The larger one, in tolerances of the goal.
  double share(const Goal& goal) const { return std::max(position / goal.tol_position, angle / goal.tol_angle); }
  bool within(const Goal& goal) const { return position <= goal.tol_position && angle <= goal.tol_angle; }
};
GoalError goal_error(const world::Model& model, dynamics::VectorRef q, const Goal& goal);

/// How far from a path counts as one tolerance: the tolerances of the goal. Where the goal leaves the rotation of its objects free, an angle counts for the way
/// that it moves the surface of the object, and of a ball not at all.
struct PathTolerances {
  double position = 0;  ///< [m]
  double angle = 0;     ///< [rad]
};
PathTolerances path_tolerances(const world::Model& model, const Goal& goal);

/// 1/PathTolerances per coordinate of the objects (n_vu) [1/m or 1/rad].
Eigen::VectorXd inverse_tolerances(const world::Model& model, const Goal& goal);

enum class SegmentKind {
  Settle,   ///< from the given start to rest on the constraints (first segment only)
  Contact,  ///< an extension: the robot pushes
  Regrasp,  ///< the robot moves to new contacts while the object rests
};

/// A piece of a plan: the sub-steps that the planner simulated.
struct Segment {
  SegmentKind kind = SegmentKind::Contact;
  std::vector<dynamics::Knot> knots;
  bool unstable =
      false;  ///< of a regrasp, the last resort: an object would not stay with gravity aside (threshold::kReleaseTilt) while branches are away
};

/// What a path costs [s]: the time of its commands when every joint keeps to its speed, and a price for each regrasp.
struct PathCost {
  double joint_speed = 0.5;   ///< [rad/s] > 0
  double travel_speed = 0.1;  ///< of sliding joints [m/s] > 0
  double regrasp = 2.0;       ///< [s] ≥ 0
  void validate() const;
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

/// max_j |to − from|_j / speed_j [s].
double command_time(const world::Model& model, const Eigen::VectorXd& from, const Eigen::VectorXd& to, const PathCost& cost);

/// Σ_k max_j |u_k − u_{k−1}|_j / speed_j + price · (number of regrasps), over all knots k.
double path_cost(const world::Model& model, const Plan& plan, const PathCost& cost);

}  // namespace stiction::planning
