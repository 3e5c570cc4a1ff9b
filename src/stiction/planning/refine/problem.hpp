#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "stiction/planning/pushes.hpp"
#include "stiction/planning/refine.hpp"
#include "stiction/planning/simulate.hpp"

namespace stiction::planning::refinement {

/// A plan that is to be refined, with the steps and the limits of the refinement.
struct Problem : Setting {
  Problem(const std::shared_ptr<const world::Model>& shared, const Plan& given, const PlannerOptions& planner_options,
          const RefineOptions& refine_options, const core::RunControl& run_control);

  const Plan& plan;
  const RefineOptions& refine;
  const core::RunControl& control;
  const Motion motion;
  int cuts = 1;   ///< steps for each step of the plan
  Pace pace;      ///< whole sub-steps, `cuts` times as short as those of the plan
  Pace halves;    ///< half sub-steps
  Worst allowed;  ///< limits at half sub-steps; a refined plan may be as bad as the given one

  /// Objects rest if they move less than this in a step.
  Allowance rest() const { return {thresholds.rest.position / cuts, thresholds.rest.angle / cuts}; }
  /// Limits of a push or a regrasp at whole sub-steps. Gaps are judged at half sub-steps only.
  Worst allowed_at_whole_steps() const { return {allowed.penetration, kUnlimited, allowed.press}; }
  /// Distance of the objects from where they should be, in tolerances of the goal.
  double miss(const Eigen::VectorXd& q_target, const Eigen::VectorXd& q) const { return goal.share_of_tolerances(q_target, q); }
  /// True if both configurations are at the goal within this fraction of its tolerances.
  bool reaches_goal(const Eigen::VectorXd& q, const Eigen::VectorXd& q_fine, double fraction) const {
    return std::max(goal.ratio(q), goal.ratio(q_fine)) <= fraction;
  }
  /// The pushes of a plan, with tails cut and without pushes that move nothing.
  std::vector<Push> shortened(const Plan& given) const;
};

/// Scratch memory of the thread that refines.
using Scratch = SimulationScratch;

/// The present state of a refinement, at whole and at half sub-steps.
struct Cursor {
  Eigen::VectorXd q{}, u{};
  Trace fine{};
};

/// A push or a regrasp that was simulated, and the state in which it ends.
struct Run {
  std::vector<Segment> segments{};
  Cursor end{};
  bool holds = false;    ///< the limits are met at half sub-steps as well
  double missed = 0;     ///< larger miss of whole and half sub-steps, in tolerances of the goal
  double clearance = 0;  ///< clearance of a regrasp that was planned anew [m]
};

/// Replays the commands of a run at half sub-steps from `start`, and sets its fields `holds` and `missed`.
void finish(const Problem& problem, const Cursor& start, const Eigen::VectorXd& q_target, Scratch& scratch, Work& work, Run& run);

/// Configuration at the end of a plan (n_q).
const Eigen::VectorXd& end_of(const Plan& plan);

}  // namespace stiction::planning::refinement
