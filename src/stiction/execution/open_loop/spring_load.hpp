#pragma once

#include "stiction/execution/open_loop/run_speed.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::execution {

/// How long it takes to strain springs, and to let them go. A spring may change the force at the reach ℓ of its joint at
///
///     |Ḟ_j| ≤ f_j + F/T_j                                                                                                          (E.24)
///
/// with f of RunSpeeds::springs, T of RunSpeeds::spring_time and the largest force F at the reach of any joint of its branch: what is pressed lightly is pressed
/// slowly, and what is pressed with many times the weight of the lightest object lets go of most of that as fast as its joints follow.
/// Tests: tests/execution/run_timing_test.cpp
class SpringLoad {
 public:
  SpringLoad(const world::Model& model, const RunSpeeds& speeds);

  /// Least time from one strain (n_a) [rad or m] to another, at even speed, by the lesser F of both [s].
  double calc_time(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;
  /// Parts of the way there in which no force changes by more than what springs that bear nothing do in T, ≥ 1.
  int count_parts(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;

 private:
  const RunSpeeds& speeds_;
  world::RobotChains chains_;
  Eigen::VectorXd force_;  ///< at the reach of a joint, by its strain (n_a) [N/rad or N/m]
};

}  // namespace stiction::execution
