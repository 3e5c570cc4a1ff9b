#pragma once

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: pairs without a closed form, by GJK and EPA. docs/theory/distance.md §5.

namespace stiction::contact::detail {

/// Signed distance of two shapes whose cores are a segment, a box, a cylinder or a mesh; no heap use. For polytopes and capsules the answer
/// is that of GJK or EPA if its lower bound (1) and upper bound agree to rounding. Otherwise, and around a cylinder, polish() refines it.
void core_distance(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context, Distance& out);

}  // namespace stiction::contact::detail
