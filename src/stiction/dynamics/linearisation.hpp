#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/contact/derivatives.hpp"
#include "stiction/dynamics/step.hpp"

// Internal to the layer: derivatives of a solved step. docs/theory/step.md, (S.5) and (S.7) – (S.10).

namespace stiction::dynamics::detail {

/// Entry of the lower triangle of Q.
struct QEntry {
  int row, column;
  double value;
};

/// The data of a solved step that its derivatives need.
struct SolvedStep {
  const world::Model& model;
  const StepOptions& options;
  const world::Kinematics& kinematics;
  const contact::Jacobians& J;
  std::span<const char> included;         ///< per contact: its rows are in the program
  bool shares;                            ///< rim points have their own shares of σ (S.17)
  std::span<const Eigen::Vector2d> rays;  ///< rays of a contact's half-lines; empty for second-order cones
  /// Variables of the bounds in the program, in order of adding: joint limits, motors, sliding joints with friction.
  std::span<const int> bound_variables;
  std::size_t moving_bounds;         ///< number of bounds at the front whose offsets move with q
  std::span<const int> motor_bound;  ///< per robot joint: index of the bound on which its spring saturates (S.15), or −1
  std::span<const QEntry> Q;
  const cone::Workspace& solver;
};

/// Row-major, because the code combines rows.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// S = −∂λ/∂w_c of a contact, stored as s sᵀ + R. In an exact step s is of the size λ/√σ, so R would lose its digits in one matrix.
struct ContactStiffness {
  Eigen::Vector3d sharp = Eigen::Vector3d::Zero();  // s
  Eigen::Matrix3d rest = Eigen::Matrix3d::Zero();   // R
};

/// The system for derivatives by q or by u, each with its own storage.
struct LinearSystem {
  Eigen::MatrixXd fixed;  // right-hand sides at constant impulses
  RowMatrix X, residual;  // solution and its residual
  Eigen::MatrixXd correction;
};

/// Scratch of linearise(), sized by its first call.
struct LinearisationWorkspace {
  std::vector<contact::Contact> contacts;
  std::vector<Eigen::Vector3d> lambda;
  std::vector<ContactStiffness> stiffness;
  contact::ContactDerivatives derivatives;
  LinearSystem by_q, by_u;
  ImpulseDerivatives D_lambda_q, D_lambda_u;
  Eigen::VectorXd slope;                  // derivative of ln share of a rim point (S.17)
  RowMatrix motion;                       // 3 × n: D_w_q + J_c X of one contact
  Eigen::MatrixXd D_momentum, D_gravity;  // derivatives for one object
  std::vector<int> actuated;              // velocity indices of the commands
  std::vector<double> h_stiffness;        // hK_a, or D of (21) for a saturated motor
};

/// Computes out.A, out.B and the impulse derivatives at the solution in `out`, as far as the options ask for them.
void linearise(const SolvedStep& step, contact::Workspace& contact_work, LinearisationWorkspace& work, StepResult& out);

}  // namespace stiction::dynamics::detail
