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
  Flat,    ///< of the triangle
  Smooth,  ///< of the corners, weighted by their angles, over triangles that meet at less than `crease`
};

struct SurfaceOptions {
  int segments = 32;       ///< triangles around a sphere, a cylinder or a capsule, ≥ 3
  int rays = 32;           ///< from each point whose visibility is tested, 0: hidden faces stay
  int postures = 4;        ///< of the assembled robot in which a face may be seen, ≥ 1: the neutral one, then random ones
  double crease = 0.8;     ///< [rad] edges sharper than this stay sharp
  std::uint64_t seed = 0;  ///< of the postures
  /// Where it is kept between processes which faces are hidden; empty, or a folder that cannot be written: nowhere.
  std::filesystem::path cache_dir{};
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// What of a link can be touched, as triangles in its frame L.
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
  std::vector<Surface> links;      ///< in the order of the bodies asked for
  std::vector<std::string> notes;  ///< links and faces that were left out, faces turned around, and edges that are open, a sentence each
};

/// What becomes of a link of which no triangle is seen.
enum class HiddenLinks {
  Refuse,
  LeaveOut,  ///< with a note; where all links are hidden they are refused
};

/// Surfaces of links of robots: the triangles of their geometry, without those that nothing can touch. A triangle is hidden if, in every
/// posture, every ray from its centre and near its corners into the open half space meets the robot. One that sees out only to its back
/// winds inwards, and is turned around.
/// @param bodies  links of robots  @throws core::InvalidInput: a link without any triangle that is seen, no link of a robot
Surfaces make_surfaces(const world::Model& model, std::span<const int> bodies, const SurfaceOptions& options,
                       HiddenLinks hidden = HiddenLinks::Refuse);

struct SurfacePoint {
  int triangle = -1;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
};

enum class Sampling {
  Uniform,     ///< independent points, uniform by area
  Stratified,  ///< one in each of equal areas, taken along the tree, so that neighbours lie apart
  BlueNoise    ///< of five times as many those that lie farthest apart
};

/// Points on a surface, the same for the same seed. @param stream  of the random numbers: one for each link
std::vector<SurfacePoint> sample_surface(const Surface& surface, int count, Sampling sampling, std::uint64_t seed);

}  // namespace stiction::sensing
