#pragma once

#include <Eigen/Core>
#include <vector>

namespace stiction::sensing {

/// Selects from many random points of a surface those that lie evenly apart, without a grid: sample elimination (Yuksel, Computer Graphics
/// Forum 2015). The point with the largest weight,
///     w_i = Σ_j (1 − min(d_ij, 2 r) / 2 r)⁸ ,   r = √(area / (2 √3 keep)) ,
/// is removed until `keep` points are left.
/// @param points  (3 × n)  @param area  of the surface [m²], > 0  @returns indices of the kept points, increasing; all points if there are
/// no more than `keep`
/// Tests: tests/sensing/surface_test.cpp
std::vector<int> eliminate_samples(const Eigen::Matrix3Xd& points, int keep, double area);

}  // namespace stiction::sensing
