#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Splits a closed triangle mesh (vertices 3 × n, outward triangles 3 × m) into nearly convex parts: the points of each (3 × k).
/// One call at a time, on one thread, with a fixed seed: equal input gives equal parts.
/// @throws core::InvalidInput when the library cannot be loaded
std::vector<Eigen::Matrix3Xd> call_coacd(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles, const Decomposition& options);

std::int64_t coacd_calls();  ///< number of calls of the library by this process

}  // namespace stiction::world
