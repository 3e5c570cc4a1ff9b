#pragma once

#include <memory>

#include "stiction/control/bounded_qp.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/planning/plan.hpp"

namespace stiction::execution {

/// Commands beside those of a plan, by which an object comes back to its planned path:
///
///   min_dδ  ‖W (q_plan ⊖ q⁺)‖² + w_u ‖(δ + dδ)/d‖² + w_du ‖dδ/d‖²   s.t.  |δ + dδ| ≤ 0.15 d , u within the joint limits          (E.22)
///
/// with q⁺ the exact step at u_plan + δ, linear in dδ by B of the smoothed step; W = 1/tolerance of the goal, d = 1 rad, or L of what slides.
class PoseTracker {
 public:
  /// @param options  of the exact steps
  PoseTracker(const std::shared_ptr<const world::Model>& model, const planning::Goal& goal, const dynamics::StepOptions& options);

  void reset() { delta_.setZero(); }
  const Eigen::VectorXd& delta() const { return delta_; }  ///< δ (n_a)
  /// Of joints that a regrasp moves (n_a, 1 or 0), a share of δ goes.
  void fade(const Eigen::VectorXd& moving, double share) { delta_.array() *= 1 - share * moving.array(); }
  /// δ for the next command of the plan. @param q  the state  @param q_plan  where the plan is after the command  @param u_plan  the command
  /// @returns Solved; else δ stays
  core::Status update(const Eigen::VectorXd& q, const Eigen::VectorXd& q_plan, const Eigen::VectorXd& u_plan);
  static constexpr long kSteps = 2;  ///< that an update computes

 private:
  std::shared_ptr<const world::Model> model_;
  dynamics::StepOptions exact_, smoothed_;
  dynamics::StepWorkspace exact_work_, smoothed_work_;
  dynamics::StepResult next_, slope_;
  Eigen::VectorXd weight_;  ///< 1/tolerance, 0 of other objects (n_vu)
  Eigen::VectorXd delta_, error_, gradient_;
  control::BoundedQp qp_;
  control::BoundedQpWorkspace qp_work_;
  control::BoundedQpResult solution_;
};

}  // namespace stiction::execution
