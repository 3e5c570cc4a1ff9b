#pragma once

#include <Eigen/Core>

#include "stiction/world/scene.hpp"

namespace stiction::sensing {

/// Triangles (3 × 3n corners) of a shape in its own frame, winding outwards. A mesh gives the triangles of its file, or else of its convex
/// hull. Round shapes get `segments` ≥ 3 triangles around, with corners on the surface. A half-space has none, because it is infinite.
Eigen::Matrix3Xd tessellate(const world::Shape& shape, int segments);

}  // namespace stiction::sensing
