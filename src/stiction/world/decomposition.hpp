#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// $XDG_CACHE_HOME/stiction or ~/.cache/stiction; empty when neither variable names an absolute folder. Reads the environment.
std::filesystem::path default_cache_dir();

/// Convex parts of a closed triangle mesh (outward triangles), by the coordinates of their centres. Equal input gives equal parts.
/// @param cache_dir  where parts are kept between processes; empty, or a folder that cannot be written, for nowhere
/// @throws core::InvalidInput when the library cannot be loaded or finds no part with a volume
std::vector<ConvexMesh> decompose(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles, const Decomposition& options,
                                  const std::filesystem::path& cache_dir);

/// Writes a file of the cache, with its folder: whole or not at all, and nothing is said where it cannot be written.
void store_in_cache(const std::filesystem::path& file, const std::string& bytes);

}  // namespace stiction::world
