#pragma once

#include <string>
#include <vector>

#include "stiction/planning/refine.hpp"

// A plan that was made for things where they are not. docs/guarded_moves.md

namespace stiction::planning {

/// Where things are, by a plan that has them elsewhere.
struct CarriedTo {
  Eigen::VectorXd q, u;                 ///< state and commands from which to begin (n_q), (n_a)
  std::vector<Eigen::Vector3d> shifts;  ///< of every object, on its whole way in the plan [m]
  Goal goal;
};

struct CarryResult {
  core::Status status = core::Status::NumericalFailure;
  Plan plan;           ///< Solved alone
  std::string reason;  ///< why not
  int pushes = 0, regrasps = 0;
  int reconnected = 0;  ///< regrasps with a new path, the way to the first push among them; the others replay the commands of the plan
  int rest_planned_anew = 0;  ///< searches for what was left
  long steps = 0;             ///< exact steps computed
  double wall_s = 0;
  double processor_s = 0;  ///< of all cores of the process
};

/// The options of a refinement that keeps a plan: its steps are as long as they are, none of its pushes goes, and nothing is searched.
RefineOptions keep_plan(const Plan& plan);

/// Carries a plan to where things are: its objects are shifted, its robots touch them at the same places (G.7), and a new path leads from where they are to its first push.
/// Everything is simulated anew with the exact dynamics, as in refine(): regrasps by the commands of the plan, or where those fail by a new path. The plan counts only if the goal is reached at the sub-step and at half of it.
/// @param model    things where they are, with the robots and objects of the plan
/// @param options  those that the plan was made with
/// @returns Solved; NumericalFailure: it comes to nothing, `out.reason` says where; Cancelled, MaxIterations (deadline)
/// @throws  core::InvalidInput: sizes, an object with a shift that does not move freely
/// Tests: tests/planning/carry_test.cpp, tests/tasks/touch_first_test.cpp
core::Status carry(const std::shared_ptr<const world::Model>& model, const Plan& plan, const CarriedTo& to, const PlannerOptions& options,
                   const RefineOptions& refine_options, const core::RunControl& control, CarryResult& out);

}  // namespace stiction::planning
