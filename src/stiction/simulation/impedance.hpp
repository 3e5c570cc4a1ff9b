#pragma once

#include <Eigen/Core>

#include "stiction/world/model.hpp"

namespace stiction::simulation {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// Options of the joint impedance controller, modelled on the factory controllers of arms.
struct ImpedanceOptions {
  double damping_ratio = 1.0;      ///< ζ with the joint inertia of the present posture [-], ≥ 0
  double velocity_cutoff = 400.0;  ///< of the low-pass on joint velocities [Hz], > 0
  double gain_cutoff = 1.0;        ///< of the low-pass on the damping gains [Hz], > 0
  double period = 2e-4;            ///< time between torque updates, a multiple of the plant's timestep [s], > 0
  void validate() const;           ///< @throws core::InvalidInput naming the field
};

/// τ = K (q_cmd − q) − D v_f ,  D_i → 2 ζ √(K_i M_ii(q)) ,  with first-order low-passes on v and D of gain a = h ω / (1 + h ω), ω = 2π · cutoff. Gravity is
/// compensated in addition.                                                                                                     (C.7)
class ImpedanceController {
 public:
  /// @param K  joint stiffness (n) [N m/rad or N/m], > 0
  ImpedanceController(const Eigen::VectorXd& K, const ImpedanceOptions& options);

  void reset() { started_ = false; }
  /// Computes the torques of one tick of options().period. @param M_ii  diagonal of the mass matrix (n)    @returns τ (n) [N m or N], valid until the next call
  const Eigen::VectorXd& update(VectorRef q, VectorRef v, VectorRef q_cmd, VectorRef M_ii);

  const ImpedanceOptions& options() const { return options_; }
  const Eigen::VectorXd& damping() const { return damping_; }

 private:
  Eigen::VectorXd K_, velocity_, damping_, torque_;
  ImpedanceOptions options_;
  bool started_ = false;
};

}  // namespace stiction::simulation
