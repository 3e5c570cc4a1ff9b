#pragma once

#include <string>
#include <vector>

#include "stiction/planning/planner.hpp"

// Refinement of a plan (3.4.5). docs/theory/refinement.md

namespace stiction::planning {

struct RefineOptions {
  std::uint64_t seed = 0;  ///< of the searches for regrasp paths; those for what is left have that of the plan's options
  /// Distances that moving branches keep to everything, tried in this order [L of the robots], each > 0. The first is one that errors of an execution stay below.
  std::vector<double> clearances = {0.2, 0.1, 0.05, 0.02};
  double h = 0.02;       ///< time step of the refined plan [s]; the steps of the plan are cut so that none is longer, > 0
  int extensions = 300;  ///< of searches for what is left of a plan where small steps leave it, in one trial, ≥ 0; 0: none
  bool reconnect = true;  ///< regrasps are planned anew; without it they are kept as they are
  void validate() const;    ///< @throws core::InvalidInput naming the field
};

struct RefineResult {
  core::Status status = core::Status::NumericalFailure;
  Plan plan;
  std::string variant;  ///< what was done: "refined" or "unchanged"
  int pushes_before = 0, pushes = 0;
  int regrasps_before = 0, regrasps = 0;
  int rest_planned_anew = 0;  ///< searches for what was left, up to the one that was followed to the goal
  int reconnected = 0;        ///< regrasps that were planned anew; the others replay the commands of the plan
  long knots_before = 0, knots = 0;
  double least_clearance = 0;  ///< of the regrasps that were planned anew [m]; 0 without any
  GoalError fine_error;        ///< at the end, at half the sub-step
  Eigen::VectorXd q_fine;      ///< there (n_q)
  long steps = 0, failed_steps = 0;
  double wall_s = 0;
};

/// Makes a plan shorter and its regrasps wider. Cut at its regrasps, a plan is a list of pushes, each from a posture of the robot. Pushes that move
/// nothing are dropped, motionless tails cut, and the robot goes from where one push leaves it to where the next one starts: it lets go, keeps the largest of the
/// clearances for which there is a path, and touches nothing before it arrives (find_path). Everything is simulated anew with the exact dynamics.
///
/// Pushes are followed in steps of `h`, until their objects rest; where a push misses its place, the rest is planned anew. The refined plan
/// counts only if the goal is reached at the sub-step and at half of it; else the plan is handed back as it was.
/// @param plan     in sub-steps, with real regrasps, at its goal
/// @param options  those that the plan was made with
/// @returns Solved; Cancelled, MaxIterations (deadline): `out.plan` is the given plan; NumericalFailure: the given plan does not reach its goal, and is handed back
/// @throws  core::InvalidInput
/// Tests: tests/planning/refine_test.cpp
core::Status refine(const std::shared_ptr<const world::Model>& model, const Plan& plan, const PlannerOptions& options,
                    const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out);

}  // namespace stiction::planning
