#pragma once

#include <memory>

#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// True if no object moves by more than kMotionless in a displacement (n_v).
bool moves_nothing(const world::Model& model, const Eigen::VectorXd& delta);

/// Damping D_i = M_ii/τ + d_i of objects on joints. The first term stands for the support that is not in the scene and stops them within τ (E.7); d is the
/// damping of their joints.
/// @returns (n_v) [N·s/m, N·m·s/rad]
Eigen::VectorXd calc_object_damping(const world::Model& model);

/// Computes the lead of the commands over the plan that lets a damped object follow the plan. Plans know next to no damping, and D q̇ strains the springs that
/// push. This strain is found with a robot so stiff that it follows the plan as it is: the difference of its joints without and with damping, times the ratio
/// of the stiffnesses,
///
///     Δu = K_a⁻¹ K_s (qᵃ_s(0) − qᵃ_s(D))                                                                                            (E.17)
///
/// with the joints qᵃ_s after an exact step from q_k, with the torques of the plan, in the time Δt of the step. A step in which no object moves has no lead.
class DragFeedforward {
 public:
  explicit DragFeedforward(std::shared_ptr<const world::Model> model);

  bool acts() const { return !damping_.isZero(0); }  ///< true if an object is damped

  struct Lead {
    Eigen::VectorXd strain;  ///< lead Δu at full speed (n_a) [rad or m]
    double speed = 1;        ///< share of full speed at which contacts and motors bear the damping, in (0, 1]
  };
  /// @param q, u          configuration at the begin of the step (n_q), and its command (n_a)
  /// @param q_next        planned configuration at the end of the step (n_q)
  /// @param duration      duration of the step at full speed [s], > 0
  /// @param unled         share of full speed at which no lead is needed, in (0, 1]. No step is slower. A step that the object follows at no speed has no lead
  Lead calc(const planning::Plan& plan, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Eigen::VectorXd& q_next, double duration,
            double unled);

 private:
  double norm(const Eigen::VectorXd& delta) const;
  bool follows(const Eigen::VectorXd& off, const Eigen::VectorXd& planned) const;
  double speed_within_efforts(const Eigen::VectorXd& strain, const Eigen::VectorXd& lead) const;

  std::shared_ptr<const world::Model> model_;
  Eigen::VectorXd damping_;                    ///< D of (E.7) (n_v) [N·s/m, N·m·s/rad]; 0 except for objects on joints
  std::shared_ptr<const world::Model> stiff_;  ///< model with the stiff robot of (E.17); model_ if nothing is damped
  dynamics::StepWorkspace work_;
  dynamics::StepResult result_;
};

}  // namespace stiction::execution
