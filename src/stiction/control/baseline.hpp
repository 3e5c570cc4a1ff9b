#pragma once

#include "stiction/control/quasi_static.hpp"
#include "stiction/core/status.hpp"

namespace stiction::control {

// Internal to the layer: baselines with contact forces as equalities. Contacts are rows of J_u; scratch is resized to (m), (m × m), (n).

struct BaselineInput {
  VectorRef stiffness;   ///< diagonal of K (n)
  VectorRef q, q_track;  ///< measured positions; best tracking command without contacts (n)
  MatrixRef J_u;         ///< (m × n)
  VectorRef lambda_max;  ///< (m) [N]
};

struct BaselineWorkspace {
  RowMatrix J, G;
  Eigen::VectorXd rhs, lambda, column;
  void reserve(Eigen::Index n, Eigen::Index contacts);
};

/// Computes q_cmd = q + (I − J^{K+} J_u)(q_track − q) − K⁻¹ J_uᵀ λ_max of the contacts that the reference does not leave,
/// J_u (q_track − q) < 0.
/// @returns Solved | NumericalFailure: dependent rows
[[nodiscard]] core::Status solve_null_space(const BaselineInput& in, BaselineWorkspace& work, Eigen::VectorXd& q_cmd);

/// The early published form, for one contact. Computes the command nearest to q_track in ‖·‖_H with (J_u⁺)ᵀ K (q_cmd − q) = −λ_max , J_u⁺ = J_uᵀ (J_u J_uᵀ)⁻¹.       (C.19)
/// @param H  factored by factor_cholesky (n × n)    @returns Solved | NumericalFailure: no joint moves the contact
[[nodiscard]] core::Status solve_force_equality(const BaselineInput& in, const RowMatrix& H, BaselineWorkspace& work,
                                                Eigen::VectorXd& q_cmd);

}  // namespace stiction::control
