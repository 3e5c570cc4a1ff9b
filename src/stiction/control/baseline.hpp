#pragma once

#include "stiction/control/quasi_static.hpp"
#include "stiction/core/status.hpp"

namespace stiction::control {

// Inside: the baselines that hold contact forces as equalities. Contacts are rows of J_u; scratch is resized to (m), (m × m), (n).

struct BaselineInput {
  VectorRef stiffness;   ///< diagonal of K (n)
  VectorRef q, q_track;  ///< measured; what tracks best without a contact (n)
  MatrixRef J_u;         ///< (m × n)
  VectorRef lambda_max;  ///< (m) [N]
};

struct BaselineWorkspace {
  RowMatrix J, G;
  Eigen::VectorXd rhs, lambda, column;
  void reserve(Eigen::Index n, Eigen::Index contacts);
};

/// q_cmd = q + (I − J^{K+} J_u)(q_track − q) − K⁻¹ J_uᵀ λ_max of the contacts that the reference does not leave, J_u (q_track − q) < 0.
/// @returns Solved | NumericalFailure: dependent rows
[[nodiscard]] core::Status solve_null_space(const BaselineInput& in, BaselineWorkspace& work, Eigen::VectorXd& q_cmd);

/// The early published form, of one contact: the nearest to q_track in ‖·‖_H with (J_u⁺)ᵀ K (q_cmd − q) = −λ_max , J_u⁺ = J_uᵀ (J_u J_uᵀ)⁻¹.       (C.19)
/// @param H  factored by factor_cholesky (n × n)    @returns Solved | NumericalFailure: no joint moves the contact
[[nodiscard]] core::Status solve_force_equality(const BaselineInput& in, const RowMatrix& H, BaselineWorkspace& work,
                                                Eigen::VectorXd& q_cmd);

}  // namespace stiction::control
