#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>

#include "stiction/control/bounded_qp.hpp"
#include "stiction/control/quasi_static.hpp"
#include "stiction/core/status.hpp"

namespace stiction::control {

/// More contacts than a robot has at a time: results over contacts have room for these and use no heap.
inline constexpr int kMaxContacts = 32;
using ContactVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxContacts, 1>;

/// What of the robot does not change from tick to tick. n joints; [rad], [N m] (or [m], [N] of prismatic joints).
struct RobotLimits {
  Eigen::VectorXd stiffness;     ///< diagonal of K (n), > 0
  Eigen::VectorXd rate;          ///< Δq_max: how far a command may change in one tick (n), > 0
  Eigen::VectorXd lower, upper;  ///< of commands (n), lower ≤ upper; may be infinite
  Eigen::VectorXd torque;        ///< largest |K (q_cmd − q)| (n), > 0; may be infinite
  void validate() const;         ///< @throws core::InvalidInput naming the field
};

/// What a command is compared with.
enum class TrackingCost {
  Command,      ///< ‖q_cmd − q_ref‖² + w ‖q_cmd − q_cmd⁻‖² , (5.24): for contacts with friction
  Equilibrium,  ///< ‖q⁺ − q_ref‖² + ε ‖q_cmd − q_ref‖² , (5.22): for contacts without
};

struct ContactQpOptions {
  TrackingCost cost = TrackingCost::Command;
  double epsilon = 1e-3;         ///< ε of (5.22) [-], > 0
  double posture_weight = 1e-3;  ///< of ‖q_cmd − q_ref‖² beside a task [1/rad²], > 0
  /// Softness of a contact as a share of the arm's own at that point, > 0. It makes forces of parallel, opposed and too many contacts unique (the nearest to
  /// the measured ones); at 0 (C.1) would be met exactly, and not be solvable for those.
  double contact_compliance = 1e-2;
  /// A contact is as soft as one with this lever where its own is shorter [m], > 0: what passes through the joint axes is borne by the structure, and no
  /// command changes it.
  double least_lever = 1e-2;
  /// Contacts that the reference does not leave, J_u (q_ref − q) < 0, do not pull: λ ≥ 0. (5.30) with its sign corrected. Off: two-sided, as in the thesis.
  bool unilateral = true;
  /// Order in which conflicts are resolved: rate, torque, joint limits, λ ≤ λ_max, λ ≥ 0, tracking. The first three hold to the last bit, an earlier one
  /// before a later one; of the other two 1/(1 + priority) of what tracking alone would break is left.
  double force_priority = 1e6;       ///< [-], in (unilateral_priority, 1e7]: conflicts are resolved to 1e-16 of it
  double unilateral_priority = 1e3;  ///< [-], > 0
  BoundedQpOptions solver{};
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// One tick. m contacts.
struct ContactQpInput {
  VectorRef q;           ///< measured (n)
  VectorRef q_cmd;       ///< command of the last tick (n)
  VectorRef q_ref;       ///< of the next tick (n); beside a task: the posture that is preferred
  MatrixRef J_u;         ///< (m × n) [m/rad]
  VectorRef lambda;      ///< measured forces (m) [N]
  VectorRef lambda_max;  ///< (m) [N], > 0
  double damping = 0;    ///< w of (5.24) [-], ≥ 0
  /// Which contacts act together (m, or empty: all do). Those of group 0 hold the arm. Those of any other number are of a set that may not be there: their forces are
  /// judged as if they were the only ones, and they hold the arm nowhere.
  std::span<const int> groups{};
  /// Tracking of a task instead of joints: ½‖E (q_cmd − q) − e‖², rows weighted by the caller; null: joints.
  const RowMatrix* task_jacobian = nullptr;     ///< E (k × n)
  const Eigen::VectorXd* task_error = nullptr;  ///< e (k)
};

struct ContactQpResult {
  core::Status status = core::Status::NumericalFailure;
  Eigen::VectorXd q_cmd;         ///< (n)
  Eigen::VectorXd q_next;        ///< predicted equilibrium (n)
  ContactVector lambda;          ///< predicted forces (m) [N]
  ContactVector slack;           ///< by which λ exceeds λ_max (m) [N], ≥ 0
  ContactVector pull;            ///< by which λ is below 0 where `unilateral` forbids it (m) [N], ≥ 0
  Eigen::VectorXd torque_slack;  ///< by which |K (q_cmd − q)| exceeds the torque (n) [N m], ≥ 0
  Eigen::VectorXd limit_slack;   ///< by which q_cmd is outside the joint limits (n) [rad], ≥ 0
  int iterations = 0;

  /// Nothing had to give way: no force above its bound by more than `force` [N], no torque above its own, no command outside joint limits.
  bool within_limits(double force) const;
};

/// Scratch and the program last solved, for tests: (C.10) in d = q_cmd − q_cmd⁻, with forces in units of λ_max.
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

/// The next command of a stiffness-controlled robot in contact: as near to the reference as forces ≤ λ_max allow, thesis (5.22) and (5.24).
///
/// With q⁺ and λ eliminated by  (J_u K⁻¹ J_uᵀ + C) λ = C λ_est − J_u (q_cmd − q) ,  C = contact_compliance · diag(J_u K⁻¹ J_uᵀ) ,          (C.4)
/// the program in the change of the command is (C.10). For C → 0 this is (5.8). One contact and a joint reference: closed form.
///
/// @returns Solved | MaxIterations: the command is within rate, torque and joint limits, slack says what else it breaks | NumericalFailure
/// @throws  core::InvalidInput: sizes, numbers that are not finite, λ_max not positive, w negative, more than kMaxContacts
/// No heap use where n and m are within what was reserved. Tests: tests/control/contact_qp_test.cpp
[[nodiscard]] core::Status solve_contact_qp(const RobotLimits& robot, const ContactQpInput& in, const ContactQpOptions& options,
                                            ContactQpWorkspace& work, ContactQpResult& out);

}  // namespace stiction::control
