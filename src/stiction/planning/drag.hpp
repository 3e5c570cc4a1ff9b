#pragma once

#include <Eigen/Core>

#include "stiction/dynamics/step.hpp"
#include "stiction/planning/speed_limits.hpp"

namespace stiction::planning {

/// What objects on planar joints, hinges and sliders rest on, which is not in the scene: in a second-order simulation it brings them to rest
/// within rest_time by a force −D q̇, D_i = M_ii/rest_time (docs/theory/verification.md, E.7). The quasi-static model knows it
/// once commands have a time (E.1).
class Drag {
 public:
  /// @param q          where masses are taken (n_q)
  /// @param rest_time  [s], > 0
  Drag(const world::Model& model, const Eigen::VectorXd& q, double rest_time);

  bool acts() const { return acts_; }                          ///< there is an object that it acts on
  const Eigen::VectorXd& damping() const { return damping_; }  ///< D (n_v) [N·s/m, N·m·s/rad], 0 but for such objects

  /// Exact steps through the commands at the speeds of execution, against the drag, and on until the robot has paused.
  /// @param commands  (n_a × k)  @param q, u  where it starts (n_q, n_a); then where it ended
  /// @param steps     counts up
  /// @returns Solved, or the status of the step that failed
  core::Status push(const Eigen::MatrixXd& commands, const dynamics::StepOptions& options, dynamics::StepWorkspace& work,
                    dynamics::StepResult& result, Eigen::VectorXd& q, Eigen::VectorXd& u, long& steps) const;

 private:
  const world::Model* model_;
  SpeedLimits limits_;
  Eigen::VectorXd speeds_;  // (n_a)
  Eigen::VectorXd damping_;
  bool acts_ = false;
};

}  // namespace stiction::planning
