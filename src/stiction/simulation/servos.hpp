#pragma once

#include <Eigen/Core>
#include <memory>

#include "stiction/simulation/plant_impl.hpp"

// Inside of the layer.

namespace stiction::simulation {

/// The joint springs of a plant, damped for the posture that they are in, as joint impedance controllers of arms do: D_j = 2 ζ √(K_j M_jj(q)).     (M.1)
/// An arm that is stretched out moves many times the inertia that it moves when it stands upright, and would swing with the damping of that.
class Servos {
 public:
  explicit Servos(const Plant::Impl& plant);

  /// @param data  with the mass matrix of the posture
  void damp(const mjData& data);

  const mjModel* mujoco() const { return mujoco_.get(); }  ///< the scene with springs damped as they are now

  /// u̇ → what commands have to be ahead, K_a⁻¹ D u̇, for a spring that is damped with −D q̇ to be one with D (u̇ − q̇): K_a⁻¹ D (n_a) [s], or 0.
  const Eigen::VectorXd& lead() const { return lead_; }

 private:
  const Plant::Impl& plant_;
  std::unique_ptr<mjModel, DeleteMujoco> mujoco_;
  Eigen::VectorXd inertia_, damping_, lead_;
};

}  // namespace stiction::simulation
