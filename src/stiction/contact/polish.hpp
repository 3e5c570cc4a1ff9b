#pragma once

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: refines an answer of GJK or EPA around a cylinder to rounding. docs/theory/distance.md §5.

namespace stiction::contact::detail {

/// Refines an answer whose normal is accurate to about 1e-2 rad until it is exact to rounding. It uses Newton's method on the features of
/// both shapes near this normal. If no pair of features fits, phi remains a true separation along the normal.
/// @param bound  known upper bound of phi of the cores [m]; features that reach it end the search
void polish(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, double bound, Distance& d);

}  // namespace stiction::contact::detail
