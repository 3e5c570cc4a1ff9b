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

/// A plant that is driven tick by tick: an impedance controller turns joint commands into joint torques. Belongs to one thread.
class DrivenPlant {
 public:
  /// @param plant  made with damping_ratio 0, because the impedance controller adds the damping
  /// @param observer  options of the observer of external torques, updated once per impedance period; nullopt: no observer
  /// @throws core::InvalidInput: a plant with damped springs, options out of range, a period that is not a multiple of the timestep
  DrivenPlant(std::shared_ptr<const Plant> plant, const ImpedanceOptions& options = {}, std::optional<ObserverOptions> observer = {});
  ~DrivenPlant();
  DrivenPlant(DrivenPlant&&) noexcept;

  /// Starts at rest in q (n_q) at time 0. @throws core::InvalidInput
  void reset(VectorRef q);

  /// Replaces the applied forces by the sum of these. @throws core::InvalidInput: no body, not finite
  void set_pushes(std::span<const Push> pushes);
  void set_push(const Push& push) { set_pushes({&push, 1}); }

  /// Holds the command (n_a) for `duration` [s], rounded to periods of the impedance controller, at least one.
  /// @returns Solved | NumericalFailure: MuJoCo warned, see message(); call reset() before going on
  core::Status advance(VectorRef command, double duration);

  const Plant& plant() const;
  double time() const;                      ///< [s]
  const Eigen::VectorXd& q() const;         ///< (n_q)
  const Eigen::VectorXd& v() const;         ///< (n_v)
  const Eigen::VectorXd& damping() const;   ///< gains D of the impedance controller (n_a) [N m s/rad or N s/m]
  const Eigen::VectorXd& torque() const;    ///< joint torques of the controller (n_a) [N m or N]
  const Eigen::VectorXd& external() const;  ///< Σ J_cᵀ f_c of contacts, joint stops, dry friction of joints and pushes (n_a) [N m or N]
  const Eigen::VectorXd& observed() const;  ///< estimate of external() by the momentum observer (n_a); 0 without an observer
  /// Wrench of contacts and pushes on the robots, as a sensor under their base measures it: force, then moment about W's origin [N; N m],
  /// with the lag of the observer and without noise; 0 without an observer.
  const Eigen::Matrix<double, 6, 1>& base_wrench() const;
  const std::vector<PairForce>& forces() const;  ///< by pair index; only pairs that touch
  const std::string& message() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stiction::simulation
