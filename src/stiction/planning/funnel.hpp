#pragma once

#include <memory>

#include "stiction/core/parallel.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/planning/refine.hpp"

// Pushes that need nobody to see where the objects are: docs/theory/execution.md, (E.11) and (E.12).

namespace stiction::planning {

/// Appends a funnel to a plan: pushes that bring the object of the goal there from wherever an execution may have left it, at rest and up to options.funnel
/// tolerances away (sensorless manipulation, Erdmann & Mason 1988). The robot goes where it is clear of the object at all such places; each push then starts
/// from there, or from where the one before has left the robot, and is taken when it brings the places nearer to the goal, Σ (distance in tolerances)² of them
/// all (E.11). What is kept are the pushes up to where the farthest place, and the plan itself in its own steps and in half of them, is nearest.
/// @param plan     at its goal, with an object that stays there when the robot leaves; unchanged where nothing comes of it
/// @param q_fine   where the plan ends at half its sub-steps (n_q)
/// @param options  those that the plan was made with
/// @param pool     pushes are drawn and tried side by side; the result does not depend on its size
Funnel append_funnel(const std::shared_ptr<const world::Model>& model, const Eigen::VectorXd& q_fine, const PlannerOptions& options,
                     const RefineOptions& refine_options, const core::RunControl& control, core::ThreadPool& pool, Plan& plan);

}  // namespace stiction::planning
