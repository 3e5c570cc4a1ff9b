#pragma once

#include <memory>

#include "stiction/dynamics/against_damping.hpp"
#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// Damping D_v = D_s + D_o of objects on joints. D_s = M_ii/τ stands for the support that is not in the scene and stops them within τ (E.7); D_o is the damping of
/// their joints.
/// @returns (n_v) [N·s/m, N·m·s/rad]
Eigen::VectorXd calc_object_damping(const world::Model& model);

/// Computes the lead Δu = u' − u of the commands over the plan that lets a damped object follow the plan. Plans know next to no damping, and its force strains the
/// springs that push. At the share f of the full speed, u' of (E.17) goes against the damping f D_v for the duration Δt of the step at full speed. A step in which
/// no damped object moves has no lead.
class DragFeedforward {
 public:
  explicit DragFeedforward(std::shared_ptr<const world::Model> model);

  bool acts() const { return !damping_.isZero(0); }  ///< true if an object is damped

  struct Lead {
    Eigen::VectorXd strain;  ///< lead Δu/f (n_a) [rad or m]
    double speed = 1;        ///< share of full speed at which contacts and motors bear the damping, in (0, 1]
  };
  /// @param q, u          configuration at the begin of the step (n_q), and its command (n_a)
  /// @param q_next        planned configuration at the end of the step (n_q)
  /// @param duration      duration of the step at full speed [s], > 0
  /// @param unled         share of full speed at which no lead is needed, in (0, 1]. No step is slower. A step that the object follows at no speed has no lead
  Lead calc(const planning::Plan& plan, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Eigen::VectorXd& q_next, double duration,
            double unled);

 private:
  double speed_within_motors(const Eigen::VectorXd& strain, const Eigen::VectorXd& lead) const;

  std::shared_ptr<const world::Model> model_;
  Eigen::VectorXd damping_;  ///< D_v (n_v) [N·s/m, N·m·s/rad]; 0 except for objects on joints
  dynamics::StepWorkspace work_;
  dynamics::StepResult result_;
};

}  // namespace stiction::execution
