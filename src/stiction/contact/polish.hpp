#pragma once

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: from Coal's answer around a cylinder to rounding. docs/theory/contact.md §5.

namespace stiction::contact::detail {

/// Replaces an answer that is good to about 1e-2 rad in the normal by one that is exact to rounding, by Newton's method on the
/// features of both shapes near its normal. Leaves phi a true separation along the normal where no pair of features fits.
void polish(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, Distance& d);

/// An answer about two polytopes that has to be looked at: not finite, not the separation along its own normal, or so deep that Coal may
/// have taken the wrong way out (it does where a gap of metre-sized bodies is a share of 1e-9 of them).
bool is_doubtful(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const Distance& d);

}  // namespace stiction::contact::detail
