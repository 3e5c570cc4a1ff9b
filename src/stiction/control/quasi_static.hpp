#pragma once

#include <Eigen/Core>

#include "stiction/control/small_cholesky.hpp"
#include "stiction/core/status.hpp"

// A stiffness-controlled robot between two equilibria, in contact with a rigid world that stands still. Signs: u_i is the unit direction of
// the force on the robot, row i of J_u is u_iᵀ J(C_i), λ_i ≥ 0 pushes the robot away.

namespace stiction::control {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using MatrixRef = Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>;

struct Equilibrium {
  core::Status status = core::Status::NumericalFailure;
  Eigen::VectorXd q;       ///< (n) [rad or m]
  Eigen::VectorXd lambda;  ///< (m) [N]
};

/// Computes the next equilibrium, the minimum of ½ (u − q⁺)ᵀ K (u − q⁺) subject to J_u (q⁺ − q) = 0:
///
///   λ = −L J_u (u − q) ,  q⁺ = q + (I − K⁻¹ J_uᵀ L J_u) (u − q) ,  L = (J_u K⁻¹ J_uᵀ)⁻¹                                     (C.1), thesis (5.9)
///
/// @param K    diagonal of the joint stiffness (n) [N m/rad or N/m], > 0
/// @param J_u  (m × n), of full row rank
/// @param q, u measured and commanded joint positions (n) [rad or m]
/// @returns Solved | NumericalFailure: J_u does not have full row rank; `out` is then not filled
/// @throws  core::InvalidInput: sizes, K not positive
/// Tests: tests/control/quasi_static_test.cpp
[[nodiscard]] core::Status calc_equilibrium(VectorRef K, MatrixRef J_u, VectorRef q, VectorRef u, Equilibrium& out);

/// Computes J^{K+} = K⁻¹ J_uᵀ L (n × m), the stiffness-consistent pseudo-inverse: commands projected by I − J^{K+} J_u move no contact
/// point, not even on the way to equilibrium; thesis (5.19)–(5.21). With it (C.1) reads  q⁺ = q + (I − J^{K+} J_u)(u − q) ,
/// λ = −(J^{K+})ᵀ K (u − q).
/// @returns Solved | NumericalFailure: J_u has not full row rank    @throws as calc_equilibrium
[[nodiscard]] core::Status calc_stiffness_consistent_inverse(VectorRef K, MatrixRef J_u, Eigen::MatrixXd& out);

}  // namespace stiction::control
