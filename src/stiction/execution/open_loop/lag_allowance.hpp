#pragma once

#include "stiction/contact/geometry_workspace.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::execution {

/// How far branches that move freely may be off their path.
/// Tests: tests/execution/run_timing_test.cpp
class LagAllowance {
 public:
  /// @param least  room that there is everywhere [m], > 0: the clearance of a regrasp
  LagAllowance(const world::Model& model, double least);

  /// Of the branches whose commands (n_a) differ, at q0 and q1 (n_q), a step apart [m]: a share of their distance to what is nearest, from `least` to the length
  /// of the robots.
  double calc(const Eigen::VectorXd& u0, const Eigen::VectorXd& u1, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1);

 private:
  world::ChainMask find_moving(const Eigen::VectorXd& u0, const Eigen::VectorXd& u1) const;
  double calc_distance(const Eigen::VectorXd& q);

  const world::Model& model_;
  world::RobotChains chains_;
  const double least_, most_;
  world::ChainMask moving_ = 0;
  Eigen::VectorXd q_;                    // where it was last …
  double distance_ = 0;                  // … and how far from everything
  contact::GeometryWorkspace geometry_;  // its pairs are those of what moves
};

}  // namespace stiction::execution
