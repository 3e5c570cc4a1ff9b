#pragma once

#include <Eigen/Core>

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// How far the polytope of an ellipsoid is from it at most, as a share of its largest semi-axis.
inline constexpr double kEllipsoidError = 0.01;

/// A polytope of 162 corners in place of an ellipsoid: half of the error outside of it, half inside. @param radii  semi-axes [m] > 0
/// Tests: tests/world/ellipsoid_test.cpp
ConvexMesh make_ellipsoid(const Eigen::Vector3d& radii);

}  // namespace stiction::world
