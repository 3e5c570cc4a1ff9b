#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "stiction/sensing/visibility.hpp"

namespace stiction::sensing {

/// Result of trim().
struct Trimmed {
  Eigen::Matrix3Xd corners;  ///< corners of the visible triangles, wound so that normals point outwards (3 × 3n)
  int hidden = 0, turned = 0, flat = 0;
};

/// Keeps the visible triangles of a link. @param visibility  nullptr: all are visible
/// @param cache_dir  cache of the answer between processes; empty, or a folder that cannot be written: no cache
Trimmed trim(const Eigen::Matrix3Xd& corners, int body, const Visibility* visibility, const std::filesystem::path& cache_dir);

/// Number of edges that border one triangle, or more than two, if triangles share corners; 0 for a closed surface.
int count_open_edges(const Eigen::Matrix3Xd& corners);

/// Area vector of a triangle: along the normal, with the area as length.
Eigen::Vector3d calc_area_vector(const Eigen::Matrix3Xd& corners, Eigen::Index triangle);

/// Diagonal of the bounding box [m].
double calc_diagonal(const Eigen::Matrix3Xd& points);

}  // namespace stiction::sensing
