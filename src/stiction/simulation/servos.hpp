#pragma once

#include <Eigen/Core>
#include <memory>

#include "stiction/simulation/plant_impl.hpp"

// Internal to the layer.

namespace stiction::simulation {

/// The joint springs of a plant. Their damping follows the present posture, as in the joint impedance controllers of arms: D_j = 2 ζ √(K_j M_jj(q)).     (M.1)
/// A stretched arm has many times the joint inertia of an upright one, and would swing with the damping of the upright posture.
/// The damping d_j of the joints in their file acts besides. The servo overcomes it up to the speed q̇* that it asks for, at which its torque
/// K_a (u − q) + D (u̇ − q̇) vanishes, with d_j clamp(q̇, 0, q̇*). All other motions feel d_j, up to M_jj/(3 h).                                               (M.5)
class Servos {
 public:
  explicit Servos(const Plant::Impl& plant);

  /// Sets the damping for the posture of `data`. @param data  has the mass matrix of the posture
  void damp(const mjData& data);

  /// Adds the torques that overcome the damping of the joints (M.5) to the commands of `data`. @param data  with the commands of this timestep
  void overcome_damping(mjData& data);

  const mjModel* mujoco() const { return mujoco_.get(); }  ///< the scene with the present damping

  /// K_a⁻¹ D (n_a) [s], or 0: the time by which commands lead. A spring with damping −D q̇ and the command u + K_a⁻¹ D u̇ acts as one with
  /// D (u̇ − q̇).
  const Eigen::VectorXd& lead() const { return lead_; }

 private:
  const Plant::Impl& plant_;
  std::unique_ptr<mjModel, DeleteMujoco> mujoco_;
  Eigen::VectorXd inertia_, damping_, lead_;
};

}  // namespace stiction::simulation
