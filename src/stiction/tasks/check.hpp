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
  std::string where;  ///< what and where the worst was, for people; may be empty
};

struct CheckReport {
  bool pass = false;
  core::Status status =
      core::Status::NumericalFailure;  ///< Solved: all checks were made; Cancelled or MaxIterations (deadline): stopped before the end
  std::vector<CheckItem> items;
  long knots = 0;
  long steps = 0;          ///< dynamics steps computed
  double threshold_N = 0;  ///< the least force that is looked at: world::share::kForce of the force of its pair
  double wall_s = 0;

  const CheckItem& at(std::string_view name) const;  ///< @throws core::InvalidInput: no such item
};

/// Limits of the check. Everything is judged against the plan's own tolerances and the task, not against what the planner aimed at.
struct CheckOptions {
  double penetration = 1;         ///< allowed beyond that of the start, in units of world::Scales::contact_tolerance of the pair
  double joint_limit = 1e-6;      ///< allowed violation by joints and commands [rad or m]
  double force_gap = 1;           ///< a force may not act across a gap larger than this, in the same units
  double cone_excess = 1e-6;      ///< allowed excess of ‖f_t‖ over μ f_n, relative to f_n
  double quaternion_norm = 1e-6;  ///< allowed deviation from 1
  double stored_position =
      1;  ///< allowed difference between a stored knot and one full sub-step from the knot before it, in world::share::kMotionless of L
  double stored_angle = 1e-3;  ///< the same for angles and joints [rad]
  double stored_force = 0.05;  ///< allowed difference of the stored forces along an object's coordinates, relative to the largest force
  double display = 2e-6;       ///< allowed rounding of body poses
};

/// The file (check_file.hpp) and the physics (check_replay.hpp) of a plan.
///
/// Re-simulates a plan from its start with the exact dynamics at half the planner's sub-step: the command of every knot is reached in
/// two steps, through the middle. Uses world, contact and dynamics::step, nothing of the planner. In addition every stored knot is
/// compared with one full sub-step from the knot before it, so that no state, command or force can be changed unnoticed.
///
/// goal_position, goal_angle      the end of the re-simulated path against the goal
/// penetration                    deepest at any re-simulated or stored state, in units of world::Scales::contact_tolerance of the pair, 1 % of its smaller object
/// joint_limits, replay_limits, command_limits   worst violation
/// command_step                   largest command increment of a knot in units of the sub-step limits
/// force_cone, force_gap          of re-simulated forces; the gap is the true distance after the step, in the same units, but while objects fall to rest at the start
/// regrasp_contact                travel of a branch in contact between its first and its last moment one such unit away from everything, in a regrasp
///                                in which it goes elsewhere
/// unstable_releases                 those in which an object moves farther than a regrasp lets it when gravity comes from 0.1 rad aside while the branches are
///                                away, from one of four sides; not judged
/// effort                         largest K_a|u − q| of a stored knot, in units of the motor's effort; judged where the plan's step bounds efforts
/// max_force                      largest normal force of a pair, re-simulated or stored, in units of what its weaker side bears; 0 where nothing is fragile. brace: of the robot on itself or on what is fixed, in units of world::share::kBrace of F, not judged
/// bystander_move, bystander_tip  how far any bystander of the task goes from where it stands at the start, re-simulated; only where the task has bystanders
/// failed_steps                   steps that were not solved
/// edited, status                 the file is as it was written (its digest), and of a plan that was solved
/// quaternion_norm, start, goal, settings, dynamics, error, stored_…, display_…     the file says what the task says and what is simulated
///
/// @param plan  matches the task, see require_same_scene
/// @returns Solved, Cancelled or MaxIterations (deadline); `out.pass` is the verdict
/// Tests: tests/tasks/check_test.cpp
core::Status check_plan(const Task& task, const PlanFile& plan, const CheckOptions& options, const core::RunControl& control,
                        CheckReport& out);

}  // namespace stiction::tasks
