#pragma once

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// True if two convex bodies have a point in common, or are nearer than a millionth of their sizes.
///
/// Computes min ‖x‖ over x in A − B by the method of Gilbert, Johnson and Keerthi (1988) on support points. Not for half-spaces.
bool overlap(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB);

}  // namespace stiction::world
