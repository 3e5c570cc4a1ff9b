#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stiction/simulation/impedance.hpp"
#include "stiction/simulation/momentum_observer.hpp"
#include "stiction/simulation/push.hpp"
#include "stiction/simulation/simulation.hpp"

namespace stiction::simulation {

/// A plant that is driven tick by tick: joint commands go to an impedance controller, its torques to the joints. Belongs to one thread.
class DrivenPlant {
 public:
  /// @param plant  made with damping_ratio 0: the damping is the controller's
  /// @param observer  of external torques, once an impedance period; nullopt: none
  /// @throws core::InvalidInput: a plant with damped springs, options out of range, a period that is not whole timesteps
  DrivenPlant(std::shared_ptr<const Plant> plant, const ImpedanceOptions& options = {}, std::optional<ObserverOptions> observer = {});
  ~DrivenPlant();
  DrivenPlant(DrivenPlant&&) noexcept;

  /// At rest in q (n_q) at time 0. @throws core::InvalidInput
  void reset(VectorRef q);

  /// Forces that act from now on, added up, in place of those before. @throws core::InvalidInput: no body, not finite
  void set_pushes(std::span<const Push> pushes);
  void set_push(const Push& push) { set_pushes({&push, 1}); }

  /// Holds the command (n_a) for `duration` [s], rounded to periods of the impedance controller, at least one.
  /// @returns Solved | NumericalFailure: MuJoCo warned, message() says what; only reset() goes on from there
  core::Status advance(VectorRef command, double duration);

  const Plant& plant() const;
  double time() const;                      ///< [s]
  const Eigen::VectorXd& q() const;         ///< (n_q)
  const Eigen::VectorXd& v() const;         ///< (n_v)
  const Eigen::VectorXd& damping() const;   ///< gains D of the impedance controller (n_a) [N m s/rad or N s/m]
  const Eigen::VectorXd& torque() const;    ///< of the joints (n_a) [N m or N]
  const Eigen::VectorXd& external() const;  ///< Σ J_cᵀ f_c of contacts, joint stops, dry friction of joints and pushes (n_a) [N m or N]
  const Eigen::VectorXd& observed() const;  ///< the same as the momentum observer has it (n_a); 0 without one
  /// What contacts and pushes do to the robots as a whole, as a sensor under their base would have it: force, then moment about W's origin, behind the lag of the
  /// observer and without noise [N; N m]; 0 without an observer.
  const Eigen::Matrix<double, 6, 1>& base_wrench() const;
  const std::vector<PairForce>& forces() const;  ///< by pair index; only pairs that touch
  const std::string& message() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stiction::simulation
