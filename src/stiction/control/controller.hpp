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

/// The control law that computes the command of a tick.
enum class Law {
  ContactAware,   ///< the program of contact_qp.hpp
  Unconstrained,  ///< baseline: tracks the reference and ignores forces and limits
  /// Baseline: stiffness-consistent null space, with the contact force as an equality,
  /// q_cmd = q + (I − J^{K+} J_u)(q_ref − q) − K⁻¹ J_uᵀ λ_max. Once the reference leaves the contact,
  /// (5.30) with its sign corrected, this law only tracks.
  NullSpace,
  /// Baseline: the early published form. The force of the strongest contact is an equality as soon as it exceeds the threshold, (C.19),
  /// even if the reference leaves the contact.
  ForceEquality,
};

struct ControllerOptions {
  Law law = Law::ContactAware;
  ContactQpOptions qp{};
  ForceDampingOptions damping{};
  double lambda_max = 15;             ///< force bound of every contact without a bound of its own [N], > 0
  double force_threshold = 5;         ///< contacts with less force are ignored [N], ≥ 0 and below the bound
  double force_time_constant = 0.05;  ///< of the low-pass on contact forces [s], ≥ 0; the filter starts at the first measurement
  /// Time in which the bound of a lost contact grows by λ_max [s], > 0, (C.15). A contact that is lost or weaker than the threshold stays
  /// bounded where it was last seen, as if it were the only contact, until the reference asks for no more than its bound. If the controller
  /// forgot the contact at once, the arm would push into it.
  double release_time = 0.5;
  int max_contacts = 8;                ///< 0 to kMaxContacts; if there are more contacts, those with the largest forces are used
  double revolute_speed = 1.5;         ///< largest speed of commands of revolute joints [rad/s], > 0
  double prismatic_speed = 0.25;       ///< the same of prismatic joints [m/s], > 0
  Eigen::VectorXd torque{};            ///< largest torque of the joint springs (n_a) [N m], > 0; empty: unbounded
  double posture_time_constant = 0.5;  ///< with which joints approach the preferred posture while a tool is tracked [s], ≥ 0
  double tool_length = 0.5;            ///< a position error of this length counts as much as 1 rad of the tool [m], > 0
  void validate() const;               ///< @throws core::InvalidInput naming the field
};

/// Options of Law::ForceEquality as published: one contact, which counts above two thirds of the bound (10 of 15 N), with a 0.5 Hz low-pass
/// on its force.
ControllerOptions make_early_form(ControllerOptions options);

/// A force on the robot, measured or estimated.
struct ContactForce {
  int id = 0;                                         ///< a contact keeps its number from tick to tick, so that its force can be predicted
  int body = -1;                                      ///< the touched link
  Eigen::Vector3d p_WC = Eigen::Vector3d::Zero();     ///< [m]
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();  ///< force on the robot [N]
  std::optional<double> lambda_max{};                 ///< force bound of this contact [N], > 0
  /// True if this contact belongs to one of several explanations of the same torques, of which only one is true. The controller then bounds
  /// its force as if the other explanations did not exist.
  bool alternative = false;
  int set = 0;  ///< number of the explanation, ≥ 0: contacts of one explanation act together
};

/// Desired pose of a tool frame that is fixed in a link.
struct ToolReference {
  int body = -1;
  world::Pose X_BT;
  world::Pose X_WT;
};

struct ControllerState {
  double time = 0;  ///< time of the measurement [s]
  VectorRef q;      ///< robot joints (n_a) [rad or m]
  VectorRef q_ref;  ///< reference of the next tick (n_a); with a tool: the preferred posture
  std::span<const ContactForce> contacts;
  const ToolReference* tool = nullptr;  ///< null: the controller tracks q_ref
  /// Share of the joint speeds of the options at which commands may change, in (0, 1]. The rate limit has priority over force bounds, so
  /// during a slow motion a false contact or a jump of a bound cannot make the command jump.
  double speed_share = 1;
};

/// The command of a tick and the quantities from which it was computed. Vectors over contacts have the order of `taken`.
struct ControllerCommand {
  core::Status status = core::Status::NumericalFailure;  ///< if not Solved, q_cmd is the command of the last tick
  Eigen::VectorXd q_cmd;                                 ///< (n_a)
  bool held = false;                                     ///< true if the measurement is no newer than the last one: nothing was computed
  std::vector<ContactForce> taken;                       ///< contacts in the program, with low-passed forces
  int left_out = 0;                                      ///< number of contacts beyond max_contacts
  double damping = 0;                                    ///< w of (5.24) [-]
  ContactVector bound;  ///< bound of each contact: λ_max minus the force that springs at rest do not explain (C.18) [N]
  ContactQpResult qp;   ///< predicted forces and slacks; Law::ContactAware only
};

/// The contact controller, with the life cycle of ros2_control: configure() once, then update() in each tick, real-time safe after the
/// first tick. Belongs to one thread.
///
/// Example: tests/control/controller_example.cpp. Tests: tests/control/controller_test.cpp
class ContactController {
 public:
  /// @throws core::InvalidInput: options out of range, a robot without stiffness, no robot
  explicit ContactController(std::shared_ptr<const world::Model> model, const ControllerOptions& options = {});
  ~ContactController();
  ContactController(ContactController&&) noexcept;

  /// Resets the controller. The present joint positions become the command. @throws core::InvalidInput: size, not finite
  void configure(VectorRef q);

  /// Computes the next command. @param dt  duration for which the command holds [s], > 0
  /// @throws core::InvalidInput: sizes, numbers that are not finite, dt ≤ 0, a bound ≤ 0, a link that is not the robot's
  /// No heap use after the first tick. The result is valid until the next call.
  const ControllerCommand& update(const ControllerState& state, double dt);

  const ControllerOptions& options() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stiction::control
