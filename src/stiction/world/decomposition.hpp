#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Splits a closed triangle mesh (outward triangles) into convex parts, sorted by the coordinates of their centres. Equal input gives equal parts.
/// @param cache_dir  folder in which parts are kept between processes; if it is empty or cannot be written, parts are not kept
/// @throws core::InvalidInput when the library cannot be loaded or finds no part with a volume
std::vector<ConvexMesh> decompose(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles, const Decomposition& options,
                                  const std::filesystem::path& cache_dir);

}  // namespace stiction::world
