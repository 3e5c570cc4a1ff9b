#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

std::string_view shape_name(const Shape& shape);  ///< "sphere", "capsule", …

/// R = Rz(yaw) Ry(pitch) Rx(roll), fixed axes [rad].
Eigen::Matrix3d rotation_from_rpy(const Eigen::Vector3d& rpy);

/// Contribution of a mass m to the inertia about a point at the offset d from its centre (Steiner) [kg m²].
Eigen::Matrix3d parallel_axis(double m, const Eigen::Vector3d& d);

/// Volume, centre and inertia of a body of unit density.
struct VolumeProperties {
  double volume = 0;                                  ///< [m³]
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   ///< [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre, density 1 kg/m³ [kg m²]
};

VolumeProperties calc_volume_properties(const Shape& shape);  ///< in the geometry frame; not for half-spaces
/// The same for several shapes together; the volume of an overlap counts once for each shape in it.
VolumeProperties calc_volume_properties(std::span<const GeometrySpec> geometries);

/// Bounding sphere in the geometry frame; radius infinite for a half-space.
struct BoundingSphere {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0;
};
BoundingSphere calc_bounding_sphere(const Shape& shape);

/// Convex hull of points (3 × n): no inner points, outward triangles. @throws core::InvalidInput for flat or too few points
ConvexMesh make_convex_hull(const Eigen::Matrix3Xd& points);

/// Treatment of a mesh that encloses less than 99 % of its convex hull.
enum class NonConvex {
  TakeHull,   ///< one hull of the whole mesh
  TakeHulls,  ///< one hull per solid if all solids of the mesh are convex; else one hull, which fills the hollows of the mesh
  Decompose   ///< convex parts, which keep the hollows open; refused if the mesh is not closed
};

struct MeshOptions {
  NonConvex non_convex = NonConvex::Decompose;
  Decomposition decomposition{};  ///< for Decompose
  double tolerance =
      0;  ///< distance by which simplify_hull may move the surface of a part, as a share of its diagonal; 0: no simplification
};

struct LoadedMesh {
  std::vector<ConvexMesh> parts;
  bool filled = false;  ///< true if TakeHulls found non-convex solids, so that the hull is larger than the mesh
  double error = 0;     ///< largest distance by which removed corners moved the surface of a part [m]
};

/// Loads an STL, OBJ or DAE file as convex parts; a convex mesh gives one part, its hull. Parts in default_cache_dir() are reused.
/// @throws core::InvalidInput with the file name
LoadedMesh load_mesh(const std::filesystem::path& file, const Eigen::Vector3d& scale, const MeshOptions& options);

/// Name of part k of a mesh with `parts` parts: NAME for one part, NAME/part_k for several.
std::string part_name(const std::string& name, std::size_t k, std::size_t parts);

/// Checks the sizes of a shape. @throws core::InvalidInput: a size that is not finite and > 0, or a mesh without vertices
void require_shape(std::string_view field, const Shape& shape);

}  // namespace stiction::world
