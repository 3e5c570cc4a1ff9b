#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stiction/simulation/push.hpp"
#include "stiction/simulation/simulation.hpp"

namespace stiction::simulation {

/// A plant driven command by command, for those who look and decide on the way: its own springs, (M.1), as simulate() has them for commands that are
/// known before. Belongs to one thread.
class SteppedPlant {
 public:
  explicit SteppedPlant(std::shared_ptr<const Plant> plant);
  ~SteppedPlant();
  SteppedPlant(SteppedPlant&&) noexcept;

  /// At rest in q (n_q) with its joints commanded to u (n_a), at time 0, without a force from outside. @throws core::InvalidInput
  void reset(VectorRef q, VectorRef u);

  /// Forces that act from now on, added up, in place of those before. @throws core::InvalidInput: no body, not finite
  void set_pushes(std::span<const Push> pushes);

  /// Commands go straight to u (n_a) in `duration` [s], rounded to timesteps, at least one.
  /// @returns Solved | NumericalFailure: MuJoCo warned, message() says what; only reset() goes on from there
  /// @throws  core::InvalidInput
  core::Status advance(VectorRef u, double duration);

  const Plant& plant() const;
  double time() const;               ///< [s]
  const Eigen::VectorXd& q() const;  ///< (n_q)
  const Eigen::VectorXd& v() const;  ///< (n_v)
  const Eigen::VectorXd& u() const;  ///< commands in force (n_a)
  /// The most that a motor has given since reset(), as a share of its effort [-]; 0 where no motor has one.
  double largest_effort() const;
  /// Of each motor the largest torque since the last call, or since reset() (n_a) [N m or N].
  Eigen::VectorXd take_torques();
  double max_depth() const;               ///< deepest penetration since reset() [m], ≥ 0
  std::vector<PairForce> forces() const;  ///< of the last step, by pair index; only pairs that touch
  const std::string& message() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stiction::simulation
