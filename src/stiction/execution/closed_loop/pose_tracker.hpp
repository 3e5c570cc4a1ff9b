#pragma once

#include <memory>

#include "stiction/control/bounded_qp.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/planning/plan.hpp"

namespace stiction::execution {

/// Corrects the commands of a plan by δ so that an object comes back to its planned path:
///
///   min_dδ  ‖(q_plan ⊖ q⁺)/tolerance‖² + w_u ‖(δ + dδ)/d‖² + w_du ‖dδ/d‖²   s.t.  |δ + dδ| ≤ 0.15 d , u within the joint limits  (E.22)
///
/// q⁺ is the exact step at u_plan + δ, linear in dδ with B of the smoothed step; tolerances are those of the goal; d = 1 rad, or L for a joint that slides.
class PoseTracker {
 public:
  /// @param options  options of the exact steps
  PoseTracker(const std::shared_ptr<const world::Model>& model, const planning::Goal& goal, const dynamics::StepOptions& options);

  void reset() { delta_.setZero(); }
  const Eigen::VectorXd& delta() const { return delta_; }  ///< δ (n_a)
  /// Reduces δ by `share` for the joints that a regrasp moves. @param moving  1 for these joints, else 0 (n_a)
  void fade(const Eigen::VectorXd& moving, double share) { delta_.array() *= 1 - share * moving.array(); }
  /// Computes δ for the next command of the plan. @param q  state  @param q_plan  planned state after the command  @param u_plan  planned command
  /// @returns Solved; any other status leaves δ unchanged
  core::Status update(const Eigen::VectorXd& q, const Eigen::VectorXd& q_plan, const Eigen::VectorXd& u_plan);
  static constexpr long kSteps = 2;  ///< number of steps computed by an update

 private:
  std::shared_ptr<const world::Model> model_;
  dynamics::StepOptions exact_, smoothed_;
  dynamics::StepWorkspace exact_work_, smoothed_work_;
  dynamics::StepResult next_, slope_;
  Eigen::VectorXd weight_;  ///< 1/tolerance, 0 for other objects (n_vu)
  Eigen::VectorXd delta_, error_, gradient_;
  control::BoundedQp qp_;
  control::BoundedQpWorkspace qp_work_;
  control::BoundedQpResult solution_;
};

}  // namespace stiction::execution
