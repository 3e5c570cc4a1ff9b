#pragma once

#include <memory>
#include <string>
#include <vector>

#include "stiction/core/status.hpp"
#include "stiction/execution/contact_control/control_scenario.hpp"

namespace stiction::execution {

/// State and command of one tick.
struct ControlSample {
  double time = 0;                              ///< [s]
  Eigen::VectorXd q, q_cmd, reference;          ///< joints (n_a), command (n_a), reference of the joints (n_a) or the tool (6)
  Eigen::VectorXd external;                     ///< external torques given to the arm, after the delay (n_a); empty: none given
  Eigen::VectorXd torque;                       ///< motor torques without gravity compensation (n_a) [N·m or N]
  std::vector<simulation::PairForce> forces;    ///< forces on the robot, of its pairs with other things and of the hand (pair −1)
  double largest_force = 0;                     ///< largest force of a single contact [N]
  double speed = 0;                             ///< ‖q̇‖ [rad/s]
  double error = 0;                             ///< tracking error ‖q − q_ref‖ [rad], or distance of the tool from its reference [m]
  double angle_error = 0;                       ///< angle between the tool and its reference [rad]
  bool bounded = false;                         ///< a predicted force is at its bound, since the reference asks for more
  double slack = 0;                             ///< largest slack of a force bound [N]
  std::vector<control::ContactForce> reported;  ///< contacts given to the controller in this tick
};

/// Runs the arm of a scenario in the second-order simulation, tick by tick: joint impedance control, above it the contact controller, with simulated or
/// estimated contacts. The caller gives the reference. Belongs to one thread.
class ControlLoop {
 public:
  /// Starts at rest in scenario.start.
  /// @param scenario  model and options that controller and estimator know; it must outlive the loop
  /// @param world  simulated model: scenario.model, or a model with the same robots and further fixed bodies
  /// @throws core::InvalidInput: options out of range, a world with other joints
  ControlLoop(const ControlScenario& scenario, std::shared_ptr<const world::Model> world);
  ~ControlLoop();
  ControlLoop(ControlLoop&&) noexcept;

  /// Runs one tick: reads the contacts, gives them to the controller, and holds its command for a period.
  /// @param reference  reference at the end of the period: joints (n_a) or displacement of the tool (6), as in ReferenceKnot
  /// @param out  state at the start of the period, and the command
  /// @returns Solved | NumericalFailure: the simulation stopped, message() says why
  core::Status tick(const Eigen::VectorXd& reference, ControlSample& out);

  /// Sets a force on a link from now on, in addition to the hand of the scenario, and replaces the one set before. Body −1 or a zero force ends it. It may be
  /// called between two ticks. The force counts as a contact. @throws core::InvalidInput: no such body, force not finite
  void hold_push(const simulation::Push& push);

  /// From now on limits the speed of commands to this share of the controller's joint speeds, in (0, 1]; 1 at first.
  void limit_speed(double share);

  double time() const;  ///< time of the next tick [s]
  const Eigen::VectorXd& q() const;
  const world::Model& world() const;  ///< the simulated model
  const std::string& message() const;
  double lag() const;                               ///< lag of contacts from observer and low-pass [s]; 0 with simulated contacts
  int unsolved_ticks() const;                       ///< ticks that the controller did not solve
  const std::vector<double>& update_times() const;  ///< processor time of each update() of the controller [s]
  const std::vector<double>& sense_times() const;   ///< processor time of each update() of the estimator, in ticks with torques [s]

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stiction::execution
