#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "stiction/control/contact_qp.hpp"
#include "stiction/control/force_damping.hpp"
#include "stiction/world/model.hpp"

namespace stiction::control {

/// What computes the command of a tick.
enum class Law {
  ContactAware,   ///< the program of contact_qp.hpp
  Unconstrained,  ///< baseline: tracking alone, without forces and limits
  /// Baseline: stiffness-consistent null space with the force as an equality,
  /// q_cmd = q + (I − J^{K+} J_u)(q_ref − q) − K⁻¹ J_uᵀ λ_max, until the reference leaves, (5.30) with its sign corrected; from then on tracking alone.
  NullSpace,
  /// Baseline: the early published form. The force of the strongest contact as an equality from the threshold on, (C.19), whether the reference leaves or not.
  ForceEquality,
};

struct ControllerOptions {
  Law law = Law::ContactAware;
  ContactQpOptions qp{};
  ForceDampingOptions damping{};
  double lambda_max = 15;             ///< bound of every contact that brings none of its own [N], > 0
  double force_threshold = 5;         ///< contacts with less force are left out [N], ≥ 0; below the bound
  double force_time_constant = 0.05;  ///< low-pass on the force of a contact [s], ≥ 0, from the first measurement on
  /// A contact that is lost, or weaker than the threshold, stays bounded where it was last seen, as if it were the only one, until the reference asks for no
  /// more than its bound, which grows by λ_max in this time [s], > 0, (C.15): to forget it at once would be answered by a push.
  double release_time = 0.5;
  int max_contacts = 8;                ///< room; of more than these those with the largest forces are taken, 0 to kMaxContacts
  double revolute_speed = 1.5;         ///< of commands [rad/s], > 0
  double prismatic_speed = 0.25;       ///< [m/s], > 0
  Eigen::VectorXd torque{};            ///< of the joint springs (n_a) [N m], > 0; empty: not bounded
  double posture_time_constant = 0.5;  ///< in which the posture beside a tool is got nearer [s], ≥ 0
  double tool_length = 0.5;            ///< a metre of the tool counts as 1/this radians [m], > 0
  void validate() const;               ///< @throws core::InvalidInput naming the field
};

/// Options of Law::ForceEquality as published: one contact, counted from two thirds of the bound on (10 of 15 N), its force through a low-pass of 0.5 Hz.
ControllerOptions make_early_form(ControllerOptions options);

/// A force on the robot, measured or estimated.
struct ContactForce {
  int id = 0;     ///< the same contact has the same number in the next tick, so that its force can be predicted
  int body = -1;  ///< link that is touched
  Eigen::Vector3d p_WC = Eigen::Vector3d::Zero();     ///< [m]
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< on the robot [N]
  std::optional<double> lambda_max{};                 ///< own bound [N], > 0
  /// Of one of several explanations of the same torques, of which one is true: bounded as if there were no other.
  bool alternative = false;
  int set = 0;  ///< of the explanations: contacts with the same number act together; ≥ 0
};

/// Where a point fixed in a link is to be.
struct ToolReference {
  int body = -1;
  world::Pose X_BT;
  world::Pose X_WT;
};

struct ControllerState {
  double time = 0;  ///< of the measurement [s]
  VectorRef q;      ///< robot joints (n_a) [rad or m]
  VectorRef q_ref;  ///< of the next tick (n_a); with a tool: the posture that is preferred
  std::span<const ContactForce> contacts;
  const ToolReference* tool = nullptr;  ///< null: joints are tracked
  /// Of the joint speeds of the options, with which commands change at most, in (0, 1]. The rate goes before bounds of forces: a contact that is not there, or a bound that
  /// jumps, then pushes no command out of a slow motion.
  double speed_share = 1;
};

/// The command of a tick and what it rests on; vectors over the contacts of `taken`.
struct ControllerCommand {
  core::Status status = core::Status::NumericalFailure;  ///< not Solved: the command of the tick before
  Eigen::VectorXd q_cmd;                                 ///< (n_a)
  bool held = false;                                     ///< the measurement is not younger than the last one: nothing was computed
  std::vector<ContactForce> taken;                       ///< contacts that count, with their forces after the low-pass
  int left_out = 0;                                      ///< contacts for which there was no room
  double damping = 0;                                    ///< w
  ContactVector bound;  ///< of each contact in the program: λ_max less what springs at rest do not explain (C.18) [N]
  ContactQpResult qp;   ///< forces predicted, slack; of Law::ContactAware
};

/// A controller as ros2_control shapes one: configured once, then one update a tick, real-time safe after that. Belongs to one thread.
///
/// Example: tests/control/controller_example.cpp. Tests: tests/control/controller_test.cpp
class ContactController {
 public:
  /// @throws core::InvalidInput: options out of range, a robot without stiffness, no robot
  explicit ContactController(std::shared_ptr<const world::Model> model, const ControllerOptions& options = {});
  ~ContactController();
  ContactController(ContactController&&) noexcept;

  /// Starts anew with the present joint positions as command. @throws core::InvalidInput: size, not finite
  void configure(VectorRef q);

  /// The next command. @param dt  for which it holds [s], > 0
  /// @throws core::InvalidInput: sizes, numbers that are not finite, dt ≤ 0, a bound ≤ 0, a link that is not the robot's
  /// No heap use after the first tick. The result is valid until the next call.
  const ControllerCommand& update(const ControllerState& state, double dt);

  const ControllerOptions& options() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stiction::control
