#pragma once

#include <memory>

#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// A displacement (n_v) in which no object moves by what counts as motion.
bool moves_nothing(const world::Model& model, const Eigen::VectorXd& delta);

/// D_i = M_ii/τ + d_i of objects on joints: what they rest on, which is not in the scene, stops them in τ (E.7), and joints have damping d of their own.
/// @returns (n_v) [N·s/m, N·m·s/rad]
Eigen::VectorXd calc_object_damping(const world::Model& model);

/// By what commands have to be ahead of a plan for an object that is damped to follow it: plans know next to no damping, and D q̇ strains the springs that push.
/// What it strains them by is that of springs so stiff that the robot goes through the plan as it is, with damping less without, in the ratio of stiffness:
///
///     Δu = K_a⁻¹ K_s (qᵃ_s(0) − qᵃ_s(D))                                                                                            (E.17)
///
/// after an exact step from q_k, with the torques of the plan, in the time Δt in which the object goes there. A step in which no object moves has no lead.
class DragFeedforward {
 public:
  explicit DragFeedforward(std::shared_ptr<const world::Model> model);

  bool acts() const { return !damping_.isZero(0); }  ///< there is an object that is damped

  struct Lead {
    Eigen::VectorXd strain;  ///< Δu for the speed given (n_a) [rad or m]
    double speed = 1;        ///< share of it at which contacts and motors bear the damping, in (0, 1]
  };
  /// @param q, u          where a step begins (n_q), and its command (n_a)
  /// @param q_next        where the plan has it end (n_q)
  /// @param duration      at full speed [s], > 0
  /// @param unled         share of that speed at which nothing needs a lead, in (0, 1]: no step is slower, and one that the object follows at no speed has none
  Lead calc(const planning::Plan& plan, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Eigen::VectorXd& q_next, double duration,
            double unled);

 private:
  double norm(const Eigen::VectorXd& delta) const;
  bool follows(const Eigen::VectorXd& off, const Eigen::VectorXd& planned) const;
  double speed_within_efforts(const Eigen::VectorXd& strain, const Eigen::VectorXd& lead) const;

  std::shared_ptr<const world::Model> model_;
  Eigen::VectorXd damping_;                    ///< D of (E.7) (n_v), 0 but for objects on joints [N·s/m, N·m·s/rad]
  std::shared_ptr<const world::Model> stiff_;  ///< the robot of (E.17); model_ where nothing is damped, for which it would be read in vain
  dynamics::StepWorkspace work_;
  dynamics::StepResult result_;
};

}  // namespace stiction::execution
