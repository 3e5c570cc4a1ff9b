#pragma once

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: from an answer of GJK or EPA around a cylinder to rounding. docs/theory/distance.md §5.

namespace stiction::contact::detail {

/// Replaces an answer that is good to about 1e-2 rad in the normal by one that is exact to rounding, by Newton's method on the
/// features of both shapes near its normal. Leaves phi a true separation along the normal where no pair of features fits.
/// @param bound  phi of the cores is no larger, as far as is known [m]: features that come up to it end the search
void polish(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, double bound, Distance& d);

}  // namespace stiction::contact::detail
