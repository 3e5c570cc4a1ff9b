#pragma once

#include "stiction/control/bounded_qp.hpp"

namespace stiction::control {

/// A diagonal H and no row, one row, or the two sides of one: A₁ = −A₀ with b₀ + b₁ ≥ 0.
bool has_closed_form(const BoundedQp& qp);

/// Solves such a program. Of the two sides of a row at most one is felt, and with its multiplier y ≥ 0
///     x(y) = clamp(x̂ − y H⁻¹ a) ,   a x(y) − y/ω = b ,
/// of which the left side falls, linearly between the multipliers at which a coordinate enters or leaves its box. What is felt is met from
/// outside, a x ≥ b, so that the other side holds: −a x ≤ −b₀ ≤ b₁.
/// @param work  1/ω as given; no heap use once it has room
void solve_closed_form(const BoundedQp& qp, BoundedQpWorkspace& work, BoundedQpResult& out);

}  // namespace stiction::control
