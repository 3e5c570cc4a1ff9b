#pragma once

#include <memory>
#include <string>
#include <vector>

#include "stiction/core/status.hpp"
#include "stiction/execution/contact_control/control_scenario.hpp"

namespace stiction::execution {

/// One tick.
struct ControlSample {
  double time = 0;                              ///< [s]
  Eigen::VectorXd q, q_cmd, reference;          ///< (n_a), (n_a), joints (n_a) or tool (6)
  Eigen::VectorXd external;                     ///< external torques as the arm is told of them, a delay old; empty where it is not (n_a)
  Eigen::VectorXd torque;                       ///< of the motors, beside what carries the weight (n_a) [N·m or N]
  std::vector<simulation::PairForce> forces;    ///< on the robot, of pairs of a robot with something else, and of the hand (pair −1)
  double largest_force = 0;                     ///< of one contact [N]
  double speed = 0;                             ///< ‖q̇‖ [rad/s]
  double error = 0;                             ///< ‖q − q_ref‖ [rad], or distance of the tool [m]
  double angle_error = 0;                       ///< of the tool [rad]
  bool bounded = false;                         ///< a force is predicted at its bound: the reference asks for more
  double slack = 0;                             ///< largest [N]
  std::vector<control::ContactForce> reported;  ///< contacts that the controller was told of in this tick
};

/// The arm of a scenario in the second-order simulation, tick by tick: impedance control of the joints, the contact controller above it, contacts as simulated
/// or estimated. Who calls it says where the reference is. Belongs to one thread.
class ControlLoop {
 public:
  /// At rest in scenario.start.
  /// @param scenario  what controller and estimator know; it outlives the loop
  /// @param world  what is simulated: scenario.model, or one with the same robots and further fixed bodies
  /// @throws core::InvalidInput: options out of range, a world with other joints
  ControlLoop(const ControlScenario& scenario, std::shared_ptr<const world::Model> world);
  ~ControlLoop();
  ControlLoop(ControlLoop&&) noexcept;

  /// Contacts are read, the controller is told of them, and its command is held for a period.
  /// @param reference  where to be at the end of the period: joints (n_a) or displacement of the tool (6), as in ReferenceKnot
  /// @param out  the state from which the period starts, and the command
  /// @returns Solved | NumericalFailure: the simulation stopped, message() says why
  core::Status tick(const Eigen::VectorXd& reference, ControlSample& out);

  /// A force on a link from now on, beside the hand of the scenario and in place of the one before; body −1 or a force of zero ends it. Whoever calls tick() may
  /// call it between two of them. It is one of the contacts. @throws core::InvalidInput: no body, not finite
  void hold_push(const simulation::Push& push);

  /// From now on commands change no faster than with this share of the joint speeds of the controller, in (0, 1]; 1 at first.
  void limit_speed(double share);

  double time() const;  ///< of the next tick [s]
  const Eigen::VectorXd& q() const;
  const world::Model& world() const;  ///< what is simulated
  const std::string& message() const;
  double lag() const;          ///< of observer and low-pass of the estimator behind contacts [s]; 0 with simulated ones
  int unsolved_ticks() const;  ///< of the controller
  const std::vector<double>& update_times() const;  ///< processor times of the controller's update() [s]
  const std::vector<double>& sense_times() const;   ///< of the estimator's, in the ticks in which it was told of torques [s]

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stiction::execution
