#pragma once

#include <string>
#include <vector>

#include "stiction/planning/planner.hpp"

// Refinement of a plan (3.4.5). docs/theory/refinement.md

namespace stiction::planning {

struct RefineOptions {
  std::uint64_t seed = 0;  ///< seed of the searches for regrasp paths; searches for the remaining way use the seed of the plan's options
  /// Clearances of moving branches, tried in this order [L of the robots], each > 0. Errors of an execution stay below the first one.
  std::vector<double> clearances = {0.2, 0.1, 0.05, 0.02};
  double h = 0.02;        ///< time step of the refined plan [s], > 0; steps of the plan are cut so that none is longer
  int extensions = 300;   ///< budget of extensions to plan the remaining way where small steps leave the plan, ≥ 0; 0: none
  bool reconnect = true;  ///< plan regrasps anew; false: keep them as they are
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

struct RefineResult {
  core::Status status = core::Status::NumericalFailure;
  Plan plan;
  std::string variant;  ///< result of the refinement: "refined" or "unchanged"
  int pushes_before = 0, pushes = 0;
  int regrasps_before = 0, regrasps = 0;
  int rest_planned_anew = 0;  ///< searches for the remaining way, up to the one that was followed to the goal
  int reconnected = 0;        ///< regrasps that were planned anew; the others replay the commands of the plan
  long knots_before = 0, knots = 0;
  double least_clearance = 0;  ///< least clearance of the regrasps that were planned anew [m]; 0 if there are none
  GoalError fine_error;        ///< error at the end, at half the sub-step
  Eigen::VectorXd q_fine;      ///< configuration at the end, at half the sub-step (n_q)
  long steps = 0, failed_steps = 0;
  double wall_s = 0;
};

/// Makes a plan shorter and gives its regrasps more clearance. Cut at its regrasps, a plan is a list of pushes, each from a posture of the
/// robot. Pushes that move nothing are dropped, and motionless tails are cut. Between two pushes the robot lets go, keeps the largest of
/// the clearances for which there is a path, and touches nothing before it arrives (find_path). Everything is simulated anew with the exact
/// dynamics.
///
/// Pushes are followed in steps of `h`, until their objects rest. If a push misses its place, the remaining way is planned anew. The
/// refined plan counts only if it reaches the goal at the sub-step and at half of it; otherwise the given plan is returned.
/// @param plan     given plan in sub-steps, with real regrasps, at its goal
/// @param options  options with which the plan was made
/// @returns Solved. Else `out.plan` is the given plan: Cancelled; MaxIterations (deadline); NumericalFailure (it does not reach its goal).
/// @throws  core::InvalidInput
/// Tests: tests/planning/refine_test.cpp
core::Status refine(const std::shared_ptr<const world::Model>& model, const Plan& plan, const PlannerOptions& options,
                    const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out);

}  // namespace stiction::planning
