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

/// A plan to be refined, in which steps, and what is allowed.
struct Problem : Setting {
  Problem(const std::shared_ptr<const world::Model>& shared, const Plan& given, const PlannerOptions& planner_options,
          const RefineOptions& refine_options, const core::RunControl& run_control);

  const Plan& plan;
  const RefineOptions& refine;
  const core::RunControl& control;
  const Motion motion;
  int cuts = 1;   ///< steps for each of the plan's
  Pace pace;      ///< whole sub-steps, `cuts` times as short as those of the plan
  Pace halves;    ///< half of them
  Worst allowed;  ///< at half sub-steps; a refined plan may be as bad as the given one

  /// Objects that move less in a step rest.
  Allowance rest() const { return {thresholds.rest.position / cuts, thresholds.rest.angle / cuts}; }
  /// Whole sub-steps of a push or a regrasp; their gaps are judged at half sub-steps.
  Worst allowed_at_whole_steps() const { return {allowed.penetration, kUnlimited, allowed.press}; }
  /// Distance of the objects from where they should be, in tolerances of the goal.
  double miss(const Eigen::VectorXd& q_target, const Eigen::VectorXd& q) const { return goal.share_of_tolerances(q_target, q); }
  /// Both are at the goal within the planner's share of its tolerances.
  bool reaches_goal(const Eigen::VectorXd& q, const Eigen::VectorXd& q_fine, double fraction) const {
    return std::max(goal.ratio(q), goal.ratio(q_fine)) <= fraction;
  }
  /// The pushes of a plan, cut and dropped as asked for.
  std::vector<Push> shortened(const Plan& given) const;
};

/// Scratch of the thread that refines.
using Scratch = SimulationScratch;

/// Where a refinement is, at whole sub-steps and at half of them.
struct Cursor {
  Eigen::VectorXd q{}, u{};
  Trace fine{};
};

/// A push or a regrasp as it was simulated, and where that left everything.
struct Run {
  std::vector<Segment> segments{};
  Cursor end{};
  bool holds = false;    ///< at half sub-steps as well
  double missed = 0;     ///< the worse of whole and half sub-steps, in tolerances of the goal
  double clearance = 0;  ///< of a regrasp that was planned anew [m]
};

/// The same commands at half sub-steps from where `start` is; sets holds and missed.
void finish(const Problem& problem, const Cursor& start, const Eigen::VectorXd& q_target, Scratch& scratch, Work& work, Run& run);

/// Where a plan ends (n_q).
const Eigen::VectorXd& end_of(const Plan& plan);

}  // namespace stiction::planning::refinement
