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

/// What a solved step leaves behind, which its derivatives are made of.
struct SolvedStep {
  const world::Model& model;
  const StepOptions& options;
  const world::Kinematics& kinematics;
  const contact::Jacobians& J;
  std::span<const char> included;         ///< per contact: its rows are in the program
  bool shares;                            ///< rims have shares of σ (S.17)
  std::span<const Eigen::Vector2d> rays;  ///< of the half-lines of a contact, none for second-order cones
  std::span<const int>
      bound_variables;               ///< of the joint limits, motors and sliding joints with friction in the program, in order of adding
  std::size_t moving_bounds;         ///< the first of them, whose offsets move with q
  std::span<const int> motor_bound;  ///< per robot joint: index among them of the row on which its spring saturates (S.15), or −1
  std::span<const QEntry> Q;
  const cone::Workspace& solver;
};

/// Rows of these are combined.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// S = −∂λ/∂w_c of a contact as s sᵀ + R. An exact step has s of λ/√σ, beside which R would lose its digits in one matrix.
struct ContactStiffness {
  Eigen::Vector3d sharp = Eigen::Vector3d::Zero();  // s
  Eigen::Matrix3d rest = Eigen::Matrix3d::Zero();   // R
};

/// The system for derivatives by q or by u, each with its own storage.
struct LinearSystem {
  Eigen::MatrixXd fixed;  // right-hand sides at constant impulses
  RowMatrix X, residual;  // solution, and what is left of the right-hand sides
  Eigen::MatrixXd correction;
};

/// Scratch; sized by the first call.
struct LinearisationWorkspace {
  std::vector<contact::Contact> contacts;
  std::vector<Eigen::Vector3d> lambda;
  std::vector<ContactStiffness> stiffness;
  contact::ContactDerivatives derivatives;
  LinearSystem by_q, by_u;
  ImpulseDerivatives D_lambda_q, D_lambda_u;
  Eigen::VectorXd slope;                  // of the share of a rim's point
  RowMatrix motion;                       // 3 × n: D_w_q + J_c X of one contact
  Eigen::MatrixXd D_momentum, D_gravity;  // of one object
  std::vector<int> actuated;              // velocity indices of the commands
  std::vector<double> h_stiffness;        // hK_a, or what is left of it where the motor is at its limit (21)
};

/// Fills out.A, out.B and the derivatives of the impulses, whichever the options ask for, at the solution in `out`.
void linearise(const SolvedStep& step, contact::Workspace& contact_work, LinearisationWorkspace& work, StepResult& out);

}  // namespace stiction::dynamics::detail
