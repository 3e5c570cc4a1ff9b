#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "stiction/sensing/friction_cone.hpp"

namespace stiction::sensing {

constexpr int kMostContacts = 3;

/// Inputs of solve_forces(): τ ≈ Σ M_i f_i with f_i in the contact frame.
struct ForceProblem {
  int contacts = 0;
  std::array<Eigen::MatrixX3d, kMostContacts> maps;  ///< M_i (rows × 3)
  Eigen::VectorXd tau;                               ///< (rows)
  double prior = 0;                                  ///< ρ of (Y.9), ≥ 0
};

/// Scratch of solve_forces(), with the active rays of the last call, from which the next call starts.
struct ForceWorkspace {
  Eigen::MatrixXd rays;  ///< M_i V (rows × n_d contacts)
  Eigen::MatrixXd gram;  ///< Gram matrix of `rays`, with ρ VᵀV added to its diagonal blocks
  Eigen::VectorXd linear, beta, slope, left;
  std::vector<int> carrying;  ///< indices of rays with β > 0
  std::vector<char> blocked;
  Eigen::MatrixXd factor;
  Eigen::VectorXd solution;
  void forget() { carrying.clear(); }
};

struct ForceSolution {
  std::array<Eigen::Vector3d, kMostContacts> forces_C;  ///< f_i in their contact frames
  double residual = 0;                                  ///< ‖Σ M_i f_i − τ‖²
  double objective = 0;                                 ///< residual + ρ Σ ‖f_i‖²
};

/// Computes the forces and the residual of several contacts at given points,
///     l(p₁ … p_k) = min_{f_i ∈ K_i} ‖Σ_i J_iᵀ f_i − τ‖² + ρ Σ_i ‖f_i‖² ,                                        (Y.9)
/// as least squares in coordinates β ≥ 0 of the rays by an active set (Lawson and Hanson 1974): ρ > 0 makes the forces unique if the
/// maps together lack full rank. A ray that depends linearly on the active rays is left out.
/// @param cone  polyhedral    Tests: tests/sensing/joint_forces_test.cpp (conditions of optimality; one contact: calc_residual)
void solve_forces(const ForceProblem& problem, const FrictionCone& cone, ForceWorkspace& work, ForceSolution& out);

}  // namespace stiction::sensing
