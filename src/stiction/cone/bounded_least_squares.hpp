#pragma once

#include <Eigen/Core>

namespace stiction::cone {

/// x = argmin ‖A x − b‖² + γ‖x‖²  subject to  lower ≤ x ≤ upper, for a flat A (m × n, m ≤ n, small m).
///
/// Active-set method: the free variables solve x = Aᵀ(A Aᵀ + γI)⁻¹ r, an m × m system; variables enter and leave their bounds one
/// at a time until the multipliers have the right signs (Lawson & Hanson 1974, ch. 23, in dual form).
/// @param lower, upper  (n) may be infinite; lower ≤ 0 ≤ upper is not required
/// @param gamma  > 0
/// @returns true when the optimality conditions hold; false when the iteration limit (4n + 20) was met, x is then feasible
bool solve_bounded_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::VectorXd>& b, double gamma,
                                 const Eigen::Ref<const Eigen::VectorXd>& lower, const Eigen::Ref<const Eigen::VectorXd>& upper,
                                 Eigen::VectorXd& x);

}  // namespace stiction::cone
