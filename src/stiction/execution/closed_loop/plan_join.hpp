#pragma once

#include "stiction/planning/plan.hpp"

namespace stiction::execution {

using dynamics::VectorRef;

struct JoinOptions {
  double off = 3;          ///< of places of the plan, by which the object may be elsewhere at most [tolerances of the goal], > 0
  double enough = 0.5;     ///< how near the goal the plan has to come [tolerances of the goal], > 0
  long max_steps = 6000;   ///< of all that is simulated, > 0
  double transit = 1;      ///< the object moves by this at most on the way to the plan [tolerances of the goal], > 0
  double joint_reach = 1;  ///< joints are as far from a place at most [rad, or L of what slides], > 0
};

/// What became of the plan that one has.
struct Join {
  core::Status status = core::Status::MaxIterations;  ///< Solved: `plan` comes to its goal
  planning::Plan plan;  ///< from the given state, as simulated: the nearest to the goal of those that were tried
  double share = 0;     ///< how far its end is from the goal, in tolerances; infinite where none was simulated
  int segment = -1;     ///< of the given plan, with which it goes on
  long steps = 0;       ///< exact steps computed
};

/// Goes on with a plan from a state beside it. Places are those of its pushes, and the starts of its regrasps, where the object is as far off as `off` at most,
/// the nearest one first. Commands go straight to those of the place and then along the rest of the plan, beside it so that the object comes back to its path
/// (E.22), under the dynamics of the plan. It counts if its end is at the goal, in half steps within the tolerances. Nothing of that is random.
/// @param q, u  the state and the commands in force (n_q), (n_a)
/// Tests: tests/execution/plan_join_test.cpp
Join join_plan(const std::shared_ptr<const world::Model>& model, const planning::Plan& plan, VectorRef q, VectorRef u,
               const JoinOptions& options = {});

}  // namespace stiction::execution
