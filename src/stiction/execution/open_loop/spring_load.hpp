#pragma once

#include "stiction/execution/open_loop/run_speed.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::execution {

/// Computes how long it takes to load and unload joint springs. The force of a spring at the reach ℓ of its joint may change at the rate
///
///     |Ḟ_j| ≤ f_j + P/T_j                                                                                                          (E.24)
///
/// with f_j from RunSpeeds::springs, T_j from RunSpeeds::spring_time, and P the largest force at the reach of any joint of the branch. Light contacts are
/// loaded slowly. A contact that presses with many times the weight of the lightest object loses most of its force as fast as the joints follow.
/// Tests: tests/execution/run_timing_test.cpp
class SpringLoad {
 public:
  SpringLoad(const world::Model& model, const RunSpeeds& speeds);

  /// Least time from one strain (n_a) [rad or m] to another at a constant rate, with the smaller P of both [s].
  double calc_time(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;
  /// Number of parts of this way in each of which no force changes by more than unloaded springs do in T_j, ≥ 1.
  int count_parts(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;

 private:
  const RunSpeeds& speeds_;
  world::RobotChains chains_;
  Eigen::VectorXd force_;  ///< force at the reach of each joint per strain (n_a) [N/rad or N/m]
};

}  // namespace stiction::execution
