#pragma once

#include <Eigen/Core>
#include <vector>

namespace stiction::sensing {

/// Which of many random points of a surface to keep so that they lie evenly apart, without a grid: sample elimination (Yuksel, Computer Graphics Forum 2015). The point
/// whose neighbours weigh most,
///     w_i = Σ_j (1 − min(d_ij, 2 r) / 2 r)⁸ ,   r = √(area / (2 √3 keep)) ,
/// is taken away until `keep` are left.
/// @param points  (3 × n)  @param area  of the surface [m²], > 0  @returns their indices, increasing; all where there are no more than `keep`
/// Tests: tests/sensing/surface_test.cpp
std::vector<int> eliminate_samples(const Eigen::Matrix3Xd& points, int keep, double area);

}  // namespace stiction::sensing
