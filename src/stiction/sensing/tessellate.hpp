#pragma once

#include <Eigen/Core>

#include "stiction/world/scene.hpp"

namespace stiction::sensing {

/// Triangles (3 × 3n corners) of a shape in its own frame, winding outwards: of a mesh those of its file where it came from one, else of
/// its convex hull; of round shapes `segments` ≥ 3 around, with corners on the surface. None of a half-space, which has no end.
Eigen::Matrix3Xd tessellate(const world::Shape& shape, int segments);

}  // namespace stiction::sensing
