#pragma once

#include "stiction/dynamics/step.hpp"

namespace stiction::dynamics {

/// True if no object moves by more than share::kMotionless in a displacement (n_v).
bool moves_nothing(const world::Model& model, const Eigen::VectorXd& delta);

/// A planned motion against the damping of objects, which the plan does without.
struct DampedMotion {
  const Eigen::VectorXd& q;        ///< configuration at the begin of the step (n_q)
  const Eigen::VectorXd& u;        ///< planned command (n_a)
  const Eigen::VectorXd& planned;  ///< δq, planned displacement (n_v)
  const Eigen::VectorXd& damping;  ///< D_v ≥ 0 of each coordinate, for the step of the options (n_v) [N·s/m, N·m·s/rad]; 0 for the robot
};

/// Finds the command with which a motion goes against damping as planned. A plan without damping says nothing about the forces that its contacts need, and
/// contacts whose force passes near the axis of a hinge cannot turn it against damping. The command is
///
///     u' = argmin ‖W (δq(u'; D_v) − δq)‖²                                                                                           (E.17)
///
/// with the motion δq(u'; D_v) of an exact step. W counts damped objects first, and then the joints of the robot, each as a share of their planned motion. The
/// robot so stays on its path, and its softer joints store nothing that would move the object later. By Newton's method with B of the exact step.
///
/// @param command  u' (n_a); u if no coordinate with damping moves
/// @returns false: objects are off by more than a fifth of their motion, or no step is solved. The contacts are jammed at this speed.
bool find_command(const world::Model& model, const DampedMotion& motion, const StepOptions& options, StepWorkspace& work,
                  StepResult& result, Eigen::VectorXd& command);

}  // namespace stiction::dynamics
