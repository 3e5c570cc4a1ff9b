#pragma once

#include <Eigen/Core>

namespace stiction::world {

/// Computes the point of triangle (a, b, c) nearest to p (Ericson §5.1.5).
Eigen::Vector3d nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace stiction::world
