#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <vector>

#include "stiction/planning/edge_simulator.hpp"
#include "stiction/planning/pushes.hpp"
#include "stiction/planning/refine.hpp"

namespace stiction::planning::refinement {

/// A plan to be refined, and what is the same in all trials. Shared by the threads.
struct Problem : Setting {
  Problem(const std::shared_ptr<const world::Model>& shared, const Plan& given, const PlannerOptions& planner_options,
          const RefineOptions& refine_options, const core::RunControl& run_control);

  const Plan& plan;
  const RefineOptions& refine;
  const core::RunControl& control;
  Motion motion;
  Eigen::VectorXd q_goal;  ///< the objects at the goal, in a whole configuration (n_q)
  Worst allowed;           ///< at half sub-steps; set_allowed

  /// A refined plan may be as bad as the given one.
  void set_allowed(const Worst& given);

  /// Distance of the objects from where they should be, in tolerances of the goal.
  double miss(const Eigen::VectorXd& q_target, const Eigen::VectorXd& q) const { return goal.share_of_tolerances(q_target, q); }

  /// The verdict on an end at whole and at half sub-steps: both are at the goal within a fraction of its tolerances.
  bool reaches_goal(const Eigen::VectorXd& q, const Eigen::VectorXd& q_fine, double fraction) const {
    return std::max(goal.ratio(q), goal.ratio(q_fine)) <= fraction;
  }

  /// The pushes of a plan, cut and dropped as asked for.
  std::vector<Push> shortened(const Plan& given) const;
};

/// Places of the objects that differ by less than this, in tolerances of the goal, are one: of a regrasp, or of ways through a push that miss.
inline constexpr double kSamePlace = 0.05;
/// A push that feedback leaves farther away than this, in tolerances of the goal, is for iMPC; a regrasp may leave the objects as far from where they are wanted.
inline constexpr double kFarOff = 0.5;

/// Every sub-step of the plan in so many of the same length.
struct StepSizes {
  StepSizes(const Problem& problem, int parts);

  int cuts;                     ///< parts of a step of the plan
  bool coarse;                  ///< longer than asked for: the last resort, where pushes end as planned and iMPC only makes things worse
  dynamics::StepOptions exact;  ///< every knot follows from the one before it alone
  dynamics::SubstepLimits substep, free_substep;  ///< … and where the branches that move touch nothing, in commands as far as in the plan
  Eigen::VectorXd limits;                         ///< of the change of the command in a sub-step (n_a) [rad or m]
};

/// Where a plan ends (n_q).
const Eigen::VectorXd& end_of(const Plan& plan);

}  // namespace stiction::planning::refinement
