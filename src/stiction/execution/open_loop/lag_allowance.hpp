#pragma once

#include "stiction/contact/geometry_workspace.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::execution {

/// Computes the allowed tracking lag c of branches in free motion (E.18).
/// Tests: tests/execution/run_timing_test.cpp
class LagAllowance {
 public:
  /// @param least  least allowance, the clearance of a regrasp [m], > 0
  LagAllowance(const world::Model& model, double least);

  /// Allowance for the branches that move between two knots with commands u0, u1 (n_a) and configurations q0, q1 (n_q) [m]: a share of their distance to the
  /// nearest obstacle, between `least` and the length L of the robots.
  double calc(const Eigen::VectorXd& u0, const Eigen::VectorXd& u1, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1);

 private:
  world::ChainMask find_moving(const Eigen::VectorXd& u0, const Eigen::VectorXd& u1) const;
  double calc_distance(const Eigen::VectorXd& q);

  const world::Model& model_;
  world::RobotChains chains_;
  const double least_, most_;
  world::ChainMask moving_ = 0;
  Eigen::VectorXd q_;                    // configuration of the last call
  double distance_ = 0;                  // distance to the nearest obstacle at q_
  contact::GeometryWorkspace geometry_;  // its pairs are those of the moving branches
};

}  // namespace stiction::execution
