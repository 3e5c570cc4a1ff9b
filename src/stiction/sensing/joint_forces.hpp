#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "stiction/sensing/friction_cone.hpp"

namespace stiction::sensing {

constexpr int kMostContacts = 3;

/// What torques say of forces at given points: τ ≈ Σ M_i f_i with f_i in the contact frame.
struct ForceProblem {
  int contacts = 0;
  std::array<Eigen::MatrixX3d, kMostContacts> maps;  ///< M_i (rows × 3)
  Eigen::VectorXd tau;                               ///< (rows)
  double prior = 0;                                  ///< ρ of a force, ≥ 0
};

/// Scratch of solve_forces(), and which rays carried in the last call, from which the next one starts.
struct ForceWorkspace {
  Eigen::MatrixXd rays;  ///< M_i V (rows × n_d contacts)
  Eigen::MatrixXd gram;  ///< with ρ VᵀV on its diagonal blocks
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
  double objective = 0;                                 ///< with ρ Σ ‖f_i‖²
};

/// The residual of several contacts at given points,
///     l(p₁ … p_k) = min_{f_i ∈ K_i} ‖Σ_i J_iᵀ f_i − τ‖² + ρ Σ_i ‖f_i‖² ,                                        (Y.9)
/// as least squares in coordinates β ≥ 0 of the rays by an active set (Lawson and Hanson 1974): ρ > 0 makes forces unique where the maps
/// together have less than full rank. A ray that depends on those that carry is left out.
/// @param cone  polyhedral    Tests: tests/sensing/joint_forces_test.cpp (conditions of optimality; one contact: calc_residual)
void solve_forces(const ForceProblem& problem, const FrictionCone& cone, ForceWorkspace& work, ForceSolution& out);

}  // namespace stiction::sensing
