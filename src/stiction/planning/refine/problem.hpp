#pragma once

#include <Eigen/Core>
#include <memory>

#include "stiction/planning/object_space.hpp"
#include "stiction/planning/press_limits.hpp"
#include "stiction/planning/pushes.hpp"
#include "stiction/planning/refine.hpp"

namespace stiction::planning::refinement {

/// Dynamics steps that were computed.
struct Work {
  long steps = 0, failed_steps = 0;
  Work& operator+=(const Work& more) {
    steps += more.steps;
    failed_steps += more.failed_steps;
    return *this;
  }
};

/// The worst that is met at half sub-steps.
struct Worst {
  double penetration = 0, force_gap = 0;  ///< in contact tolerances of their pairs
  double press = 0;                       ///< PressLimits::share
};

/// A plan to be refined, and what is the same in all trials. Shared by the threads.
struct Problem {
  Problem(std::shared_ptr<const world::Model> shared, const Plan& given, const PlannerOptions& planner_options,
          const RefineOptions& refine_options, const core::RunControl& run_control);

  std::shared_ptr<const world::Model> shared_model;
  const world::Model& model;
  const Plan& plan;
  const PlannerOptions& options;
  const RefineOptions& refine;
  const core::RunControl& control;
  ObjectSpace space;
  Motion motion;
  RobotChains chains;
  PressLimits press;
  Eigen::VectorXd weights;  ///< 1/tolerance of the goal (n_vu) [1/m or 1/rad]
  Eigen::VectorXd q_goal;   ///< the objects at the goal, in a whole configuration (n_q)
  Worst allowed;            ///< at half sub-steps; set_allowed

  /// A refined plan may be as bad as the given one.
  void set_allowed(const Worst& given);

  /// Distance of the objects from where they should be, in tolerances of the goal.
  double miss(const Eigen::VectorXd& q_target, const Eigen::VectorXd& q) const;

  /// The verdict on an end at whole and at half sub-steps: both are at the goal within a fraction of its tolerances.
  bool reaches_goal(const Eigen::VectorXd& q, const Eigen::VectorXd& q_fine, double fraction) const;

  /// Time that so many steps take, in the unit of RefineOptions::mpc_work.
  double cost(long steps) const;
};

/// What takes more work than this, in the unit of RefineOptions::mpc_work, is not tried where there is little hope: some tenths of a second.
inline constexpr double kLittleHope = 5e8;
/// Places of the objects that differ by less than this, in tolerances of the goal, are one: of a regrasp, or of ways through a push that miss.
inline constexpr double kSamePlace = 0.05;

/// Where a plan ends (n_q).
const Eigen::VectorXd& end_of(const Plan& plan);

}  // namespace stiction::planning::refinement
