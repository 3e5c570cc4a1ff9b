#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Convex parts of a closed triangle mesh (outward triangles), by the coordinates of their centres. Equal input gives equal parts.
/// @param cache_dir  where parts are kept between processes; empty, or a folder that cannot be written, for nowhere
/// @throws core::InvalidInput when the library cannot be loaded or finds no part with a volume
std::vector<ConvexMesh> decompose(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles, const Decomposition& options,
                                  const std::filesystem::path& cache_dir);

}  // namespace stiction::world
