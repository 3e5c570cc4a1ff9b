#pragma once

#include "stiction/planning/plan.hpp"

namespace stiction::execution {

using dynamics::VectorRef;

struct JoinOptions {
  double off = 3;          ///< largest distance of the object from a place of the plan [tolerances of the goal], > 0
  double enough = 0.5;     ///< largest distance from the goal at the end of the plan [tolerances of the goal], > 0
  long max_steps = 6000;   ///< largest number of simulated steps in all, > 0
  double transit = 1;      ///< largest motion of the object on the way to the plan [tolerances of the goal], > 0
  double joint_reach = 1;  ///< largest distance of a joint from a place [rad, or L of a joint that slides], > 0
};

/// Result of join_plan.
struct Join {
  core::Status status = core::Status::MaxIterations;  ///< Solved: `plan` reaches its goal
  planning::Plan plan;  ///< simulated plan from the given state: the one that ends nearest to the goal of all that were tried
  double share = 0;     ///< distance of its end from the goal [tolerances]; infinite if none was simulated
  int segment = -1;     ///< segment of the given plan with which it goes on
  long steps = 0;       ///< exact steps computed
};

/// Continues a plan from a state beside its path. Candidate places are the knots of its pushes and the starts of its regrasps at which the object is off by at
/// most `off`; the nearest place is tried first. The commands go straight to those of the place and then along the rest of the plan. A correction (E.22) brings
/// the object back to its path. The motion is simulated with the dynamics of the plan. It counts if it ends within `enough` of the goal, and within the
/// tolerances in half steps. The function is deterministic.
/// @param q, u  state (n_q) and commands in force (n_a)
/// Tests: tests/execution/plan_join_test.cpp
Join join_plan(const std::shared_ptr<const world::Model>& model, const planning::Plan& plan, VectorRef q, VectorRef u,
               const JoinOptions& options = {});

}  // namespace stiction::execution
