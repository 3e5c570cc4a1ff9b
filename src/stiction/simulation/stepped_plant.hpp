#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stiction/simulation/push.hpp"
#include "stiction/simulation/simulation.hpp"

namespace stiction::simulation {

/// A plant that is driven command by command, for callers that choose the next command from the present state. The joint springs (M.1) are
/// those of simulate(), which takes all commands in advance. Belongs to one thread.
class SteppedPlant {
 public:
  explicit SteppedPlant(std::shared_ptr<const Plant> plant);
  ~SteppedPlant();
  SteppedPlant(SteppedPlant&&) noexcept;

  /// Starts at rest in q (n_q) with commands u (n_a), at time 0, without external forces. @throws core::InvalidInput
  void reset(VectorRef q, VectorRef u);

  /// Replaces the applied forces by the sum of these. @throws core::InvalidInput: no body, not finite
  void set_pushes(std::span<const Push> pushes);

  /// Moves the commands linearly to u (n_a) in `duration` [s], rounded to timesteps, at least one.
  /// @returns Solved | NumericalFailure: MuJoCo warned, see message(); call reset() before going on
  /// @throws  core::InvalidInput
  core::Status advance(VectorRef u, double duration);

  const Plant& plant() const;
  double time() const;               ///< [s]
  const Eigen::VectorXd& q() const;  ///< (n_q)
  const Eigen::VectorXd& v() const;  ///< (n_v)
  const Eigen::VectorXd& u() const;  ///< present commands (n_a)
  /// Largest motor torque since reset(), as a share of the effort of that motor [-]; 0 if no motor states an effort.
  double largest_effort() const;
  /// Largest torque of each motor since the last call, or since reset() (n_a) [N m or N].
  Eigen::VectorXd take_torques();
  double max_depth() const;               ///< deepest penetration since reset() [m], ≥ 0
  std::vector<PairForce> forces() const;  ///< forces of the last step, by pair index; only pairs that touch
  const std::string& message() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stiction::simulation
