#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "stiction/core/random.hpp"
#include "stiction/sensing/triangle_tree.hpp"
#include "stiction/world/model.hpp"

namespace stiction::sensing {

enum class Normals {
  Flat,    ///< normal of the triangle
  Smooth,  ///< interpolated corner normals: angle-weighted means over triangles that meet at less than `crease`
};

struct SurfaceOptions {
  int segments = 32;       ///< triangles around a sphere, a cylinder or a capsule, ≥ 3
  int rays = 32;           ///< rays from each point in the visibility test; 0: no test, hidden faces stay
  int postures = 4;        ///< postures of the robot in the visibility test, ≥ 1: the neutral one, then random ones
  double crease = 0.8;     ///< [rad] edges sharper than this stay sharp
  std::uint64_t seed = 0;  ///< seed of the postures
  /// Folder of the cache of hidden faces, kept between processes; empty, or a folder that cannot be written: no cache.
  std::filesystem::path cache_dir{};
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// The touchable surface of a link, as triangles in its frame L.
struct Surface {
  int body = -1;
  TriangleTree tree;
  Eigen::Matrix3Xd normals;         ///< outward, per triangle (3 × n)
  Eigen::Matrix3Xd corner_normals;  ///< outward, smoothed, per corner (3 × 3n)
  Eigen::VectorXd areas_below;      ///< area of triangles 0 … i [m²] (n)
  double area = 0;                  ///< [m²]
  double size = 0;                  ///< diagonal of its bounding box [m]

  Eigen::Vector3d normal(int triangle, const Eigen::Vector3d& p_L, Normals kind) const;
};

struct Surfaces {
  std::vector<Surface> links;      ///< in the order of the requested bodies
  std::vector<std::string> notes;  ///< a sentence each on links and faces left out, faces turned around, and open edges
};

/// Treatment of a link without visible triangles.
enum class HiddenLinks {
  Refuse,
  LeaveOut,  ///< with a note; if all links are hidden, an exception is thrown
};

/// Makes the surfaces of robot links: the triangles of their geometry without hidden ones, which nothing can touch. A triangle is hidden
/// if, in every posture, every ray from its centre and near its corners into the open half space meets the robot. A triangle that is
/// visible only from its back winds inwards and is turned around.
/// @param bodies  links of robots  @throws core::InvalidInput: a link without visible triangles, a body that is no link of a robot
Surfaces make_surfaces(const world::Model& model, std::span<const int> bodies, const SurfaceOptions& options,
                       HiddenLinks hidden = HiddenLinks::Refuse);

struct SurfacePoint {
  int triangle = -1;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
};

enum class Sampling {
  Uniform,     ///< independent points, uniform by area
  Stratified,  ///< one random point in each of `count` parts of equal area, in the order of the tree, so that neighbours lie apart
  BlueNoise    ///< five times as many stratified points, thinned to those that lie farthest apart
};

/// Samples points on a surface. Equal seeds give equal points; each link has its own stream of random numbers.
std::vector<SurfacePoint> sample_surface(const Surface& surface, int count, Sampling sampling, std::uint64_t seed);

}  // namespace stiction::sensing
