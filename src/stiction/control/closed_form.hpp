#pragma once

#include "stiction/control/bounded_qp.hpp"

namespace stiction::control {

/// Whether the program has a closed form: H is diagonal, and there is no row, one row, or the two sides of one row,
/// A₁ = −A₀ with b₀ + b₁ ≥ 0.
bool has_closed_form(const BoundedQp& qp);

/// Solves a program that has_closed_form(). At most one of the two sides of a row is active. With its multiplier y ≥ 0,
///     x(y) = clamp(x̂ − y H⁻¹ a) ,   a x(y) − y/ω = b ,
/// whose left side decreases with y, and is linear between the multipliers at which a coordinate enters or leaves its box. The solution
/// satisfies a x ≥ b for the active side, so the other side holds as well: −a x ≤ −b₀ ≤ b₁.
/// @param work  has 1/ω as input; no heap use once it is large enough
void solve_closed_form(const BoundedQp& qp, BoundedQpWorkspace& work, BoundedQpResult& out);

}  // namespace stiction::control
