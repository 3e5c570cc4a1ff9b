#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>

#include "stiction/control/bounded_qp.hpp"
#include "stiction/control/quasi_static.hpp"
#include "stiction/core/status.hpp"

namespace stiction::control {

/// Largest number of contacts. Results over contacts have room for this number and use no heap.
inline constexpr int kMaxContacts = 32;
using ContactVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxContacts, 1>;

/// Constants of the robot, the same in all ticks. n joints; [rad], [N m] (or [m], [N] of prismatic joints).
struct RobotLimits {
  Eigen::VectorXd stiffness;     ///< diagonal of K (n), > 0
  Eigen::VectorXd rate;          ///< Δq_max: largest change of a command in one tick (n), > 0
  Eigen::VectorXd lower, upper;  ///< limits of commands (n), lower ≤ upper; may be infinite
  Eigen::VectorXd torque;        ///< largest |K (q_cmd − q)| (n), > 0; may be infinite
  void validate() const;         ///< @throws core::InvalidInput naming the field
};

/// The tracking cost of a command.
enum class TrackingCost {
  Command,      ///< ‖q_cmd − q_ref‖² + w ‖q_cmd − q_cmd⁻‖² , (5.24): use with friction
  Equilibrium,  ///< ‖q⁺ − q_ref‖² + ε ‖q_cmd − q_ref‖² , (5.22): use without friction
};

struct ContactQpOptions {
  TrackingCost cost = TrackingCost::Command;
  double epsilon = 1e-3;         ///< ε of (5.22) [-], > 0
  double posture_weight = 1e-3;  ///< weight of ‖q_cmd − q_ref‖² while a task is tracked [1/rad²], > 0
  /// Compliance of a contact as a share of the arm's compliance at that point, > 0. It makes the forces of parallel, opposed or too many
  /// contacts unique: the solution nearest to the measured forces. At 0, (C.1) would hold exactly but could not be solved for such
  /// contacts.
  double contact_compliance = 1e-2;
  /// Smallest lever for the compliance of a contact [m], > 0; shorter levers count as this one. The structure bears a force that passes
  /// through the joint axes, and no command changes this force.
  double least_lever = 1e-2;
  /// Contacts that the reference does not leave, J_u (q_ref − q) < 0, do not pull: λ ≥ 0. (5.30) with its sign corrected. If false, the
  /// constraint is two-sided, as in the thesis.
  bool unilateral = true;
  /// Conflicts are resolved in this order: rate, torque, joint limits, λ ≤ λ_max, λ ≥ 0, tracking. The first three hold exactly, and an
  /// earlier limit has precedence over a later one. Of the violation of the two force limits by tracking alone, the share 1/(1 + priority)
  /// remains.
  double force_priority = 1e6;       ///< [-], in (unilateral_priority, 1e7]: conflicts are resolved to 1e-16 of it
  double unilateral_priority = 1e3;  ///< [-], > 0
  BoundedQpOptions solver{};
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// Inputs of one tick with m contacts.
struct ContactQpInput {
  VectorRef q;           ///< measured (n)
  VectorRef q_cmd;       ///< command of the last tick (n)
  VectorRef q_ref;       ///< reference of the next tick (n); with a task: the preferred posture
  MatrixRef J_u;         ///< (m × n) [m/rad]
  VectorRef lambda;      ///< measured forces (m) [N]
  VectorRef lambda_max;  ///< (m) [N], > 0
  double damping = 0;    ///< w of (5.24) [-], ≥ 0
  /// Group of each contact (m); empty: all contacts act together. Contacts of group 0 hold the arm. Every other group is a set of contacts
  /// that may not exist: its forces are bounded as if they were the only ones, and its contacts do not hold the arm.
  std::span<const int> groups{};
  /// Tracks a task instead of joints, with the cost ½‖E (q_cmd − q) − e‖²; the caller weights the rows. Null: joints are tracked.
  const RowMatrix* task_jacobian = nullptr;     ///< E (k × n)
  const Eigen::VectorXd* task_error = nullptr;  ///< e (k)
};

struct ContactQpResult {
  core::Status status = core::Status::NumericalFailure;
  Eigen::VectorXd q_cmd;         ///< (n)
  Eigen::VectorXd q_next;        ///< predicted equilibrium (n)
  ContactVector lambda;          ///< predicted forces (m) [N]
  ContactVector slack;           ///< excess of λ over λ_max (m) [N], ≥ 0
  ContactVector pull;            ///< amount by which λ is below 0 although `unilateral` forbids it (m) [N], ≥ 0
  Eigen::VectorXd torque_slack;  ///< excess of |K (q_cmd − q)| over RobotLimits::torque (n) [N m], ≥ 0
  Eigen::VectorXd limit_slack;   ///< distance of q_cmd from the joint limits (n) [rad], ≥ 0
  int iterations = 0;

  /// Whether all limits hold: no force exceeds its bound by more than `force` [N], no torque exceeds its limit, no command is outside the
  /// joint limits.
  bool within_limits(double force) const;
};

/// Scratch, and the last program (C.10) for tests. Its variable is d = q_cmd − q_cmd⁻, and its forces are in units of λ_max.
struct ContactQpWorkspace {
  void reserve(Eigen::Index n, Eigen::Index contacts);

  BoundedQp qp;
  BoundedQpWorkspace solver;
  BoundedQpResult solution;
  RowMatrix G, LJ;                      // J K⁻¹ Jᵀ + compliance, factored; (…)⁻¹ J
  RowMatrix EP;                         // task Jacobian times the projection of (5.20)
  Eigen::VectorXd compliance, lambda0;  // of the contacts; λ at d = 0
  Eigen::VectorXd offset, column;       // q_cmd⁻ − q
  Eigen::VectorXd residual;
};

/// Computes the next command of a stiffness-controlled robot in contact: the command that tracks the reference best with forces ≤ λ_max,
/// thesis (5.22) and (5.24).
///
/// The equation that eliminates q⁺ and λ is  (J_u K⁻¹ J_uᵀ + C) λ = C λ_est − J_u (q_cmd − q) ,  C = contact_compliance · diag(J_u K⁻¹ J_uᵀ) ,          (C.4)
/// and leaves the program (C.10) in the change of the command. For C → 0 this is (5.8). One contact and a joint reference have a closed
/// form.
///
/// @returns Solved | MaxIterations: the command is within rate, torque and joint limits, and `slack` has the excess of the forces
/// | NumericalFailure
/// @throws  core::InvalidInput: sizes, numbers that are not finite, λ_max not positive, w negative, more than kMaxContacts
/// No heap use as long as n and m do not exceed the reserved sizes. Tests: tests/control/contact_qp_test.cpp
[[nodiscard]] core::Status solve_contact_qp(const RobotLimits& robot, const ContactQpInput& in, const ContactQpOptions& options,
                                            ContactQpWorkspace& work, ContactQpResult& out);

}  // namespace stiction::control
