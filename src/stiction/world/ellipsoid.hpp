#pragma once

#include <Eigen/Core>

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Largest distance between an ellipsoid and its polytope, as a share of the largest semi-axis.
inline constexpr double kEllipsoidError = 0.01;

/// Approximates an ellipsoid by a polytope with 162 corners; half of the error is outside the ellipsoid, half inside. @param radii  semi-axes [m] > 0
/// Tests: tests/world/ellipsoid_test.cpp
ConvexMesh make_ellipsoid(const Eigen::Vector3d& radii);

}  // namespace stiction::world
