#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "stiction/sensing/visibility.hpp"

namespace stiction::sensing {

/// What became of the triangles of a link.
struct Trimmed {
  Eigen::Matrix3Xd corners;  ///< of those that are seen, wound so that they are seen from where their normals point (3 × 3n)
  int hidden = 0, turned = 0, flat = 0;
};

/// The triangles of a link that are seen. @param visibility  nullptr: all are
/// @param cache_dir  where the answer is kept between processes; empty, or a folder that cannot be written: nowhere
Trimmed trim(const Eigen::Matrix3Xd& corners, int body, const Visibility* visibility, const std::filesystem::path& cache_dir);

/// Edges that border one triangle, or more than two, where triangles share corners: 0 of a closed surface.
int count_open_edges(const Eigen::Matrix3Xd& corners);

/// Half the cross product of two sides: along the normal, as long as the area.
Eigen::Vector3d calc_area_vector(const Eigen::Matrix3Xd& corners, Eigen::Index triangle);

/// Diagonal of the bounding box [m].
double calc_diagonal(const Eigen::Matrix3Xd& points);

}  // namespace stiction::sensing
