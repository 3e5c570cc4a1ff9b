#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// One named figure of a check.
struct CheckItem {
  std::string name;
  double value = 0;
  std::optional<double> limit;  ///< the largest good value; nullopt: reported, not judged
  std::string unit;             ///< "m", "rad", "N", "" …
  bool pass = true;
  std::string where;  ///< description of the worst case and its place, for people; may be empty
};

struct CheckReport {
  bool pass = false;
  core::Status status =
      core::Status::NumericalFailure;  ///< Solved: all checks were made; Cancelled or MaxIterations (deadline): stopped before the end
  std::vector<CheckItem> items;
  long knots = 0;
  long steps = 0;          ///< dynamics steps computed
  double threshold_N = 0;  ///< smallest force that is checked: world::share::kForce times the force of its pair
  double wall_s = 0;

  const CheckItem& at(std::string_view name) const;  ///< @throws core::InvalidInput: no such item
};

/// Limits of the check. The plan is judged against its own tolerances and the task, not against the planner's internal targets.
struct CheckOptions {
  double penetration = 1;         ///< allowed penetration beyond that of the start, in units of the pair's world::Scales::contact_tolerance
  double joint_limit = 1e-6;      ///< allowed violation by joints and commands [rad or m]
  double force_gap = 1;           ///< largest gap across which a force may act, in the same units
  double cone_excess = 1e-6;      ///< allowed excess of ‖f_t‖ over μ f_n, relative to f_n
  double quaternion_norm = 1e-6;  ///< allowed deviation of a quaternion's norm from 1
  double stored_position =
      1;  ///< allowed difference between a stored knot and one full sub-step from the knot before it, in world::share::kMotionless of L
  double stored_angle = 1e-3;  ///< the same for angles and joints [rad]
  double stored_force = 0.05;  ///< allowed difference of the stored forces along an object's coordinates, relative to the largest force
  double display = 2e-6;       ///< allowed rounding of body poses
};

/// Checks the file (check_file.hpp) and the physics (check_replay.hpp) of a plan.
///
/// Re-simulates a plan from its start with the exact dynamics at half the planner's sub-step: each knot's command is reached in two steps.
/// The check uses world, contact and dynamics::step, and no code of the planner. It also compares every stored knot with one full sub-step
/// from the knot before it, so that no state, command or force can be changed unnoticed.
///
/// goal_position, goal_angle      distance of the end of the re-simulated path from the goal
/// penetration                    deepest penetration of any re-simulated or stored state, in units of the pair's
///                                world::Scales::contact_tolerance, which is 1 % of its smaller object
/// joint_limits, replay_limits, command_limits   worst violation
/// command_step                   largest command increment of a knot in units of the sub-step limits
/// force_cone, force_gap          excess over the friction cone, and gap, of re-simulated forces. The gap is the true distance after the
///                                step, in the same units; it is not checked while objects fall to rest at the start
/// regrasp_contact                in a regrasp that moves a branch elsewhere: travel of the branch in contact between the first and the
/// last
///                                moment at which it is one such unit away from everything
/// unstable_releases              releases in which an object moves farther than a regrasp allows, if gravity is tilted by 0.1 rad to one
/// of
///                                four sides while the branches are away; not judged
/// effort                         largest K_a|u − q| of a stored knot, in units of the motor's effort; judged if the plan's step limits
/// efforts max_force                      largest normal force of a pair, re-simulated or stored, in units of the force that its weaker
/// side bears;
///                                0 if nothing is fragile
/// brace                          the same for the robot on itself or on fixed bodies, in units of world::share::kBrace of F; not judged
/// bystander_move, bystander_tip  largest motion of a bystander from its start, re-simulated; only if the task has bystanders
/// failed_steps                   steps that were not solved
/// edited, status                 the file matches its digest, and the plan was solved
/// quaternion_norm, start, goal, settings, dynamics, error, stored_…, display_…     the file agrees with the task and with the simulation
///
/// @param plan  must match the task, see require_same_scene
/// @returns Solved, Cancelled or MaxIterations (deadline); `out.pass` is the verdict
/// Tests: tests/tasks/check_test.cpp
core::Status check_plan(const Task& task, const PlanFile& plan, const CheckOptions& options, const core::RunControl& control,
                        CheckReport& out);

}  // namespace stiction::tasks
