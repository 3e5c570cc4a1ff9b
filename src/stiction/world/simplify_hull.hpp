#pragma once

#include <string>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Of the diagonal of a mesh: how far the hulls of a robot's meshes may be from those of its files. Half a millimetre of a link of 0.25 m.
inline constexpr double kHullTolerance = 2e-3;

struct SimplifiedHull {
  ConvexMesh mesh;   ///< the hull of some of the corners: inside the given one
  double error = 0;  ///< Hausdorff distance between the two [m]
};

/// Leaves out corners of a convex mesh as long as its surface moves by no more than `tolerance` [m]. A cost of contact queries grows with the
/// number of corners, and files have thousands of them on surfaces that are round.
///
/// Corners that lie farthest outside join the hull until none is farther from it than the tolerance. Equal meshes give equal results.
/// @throws core::InvalidInput: tolerance negative or not finite
/// Tests: tests/world/simplify_hull_test.cpp
SimplifiedHull simplify_hull(const ConvexMesh& mesh, double tolerance);

/// The same with a tolerance relative to the diagonal of the mesh, such as kHullTolerance.
SimplifiedHull simplify_hull_by_share(const ConvexMesh& mesh, double share);

/// The meshes of one robot's links that lost corners, for its note.
class LinkHulls {
 public:
  /// @param error  of its hull [m]
  void add(double error, const std::string& name);

  /// How far which surfaces moved; nothing where none did.
  void add_note(std::vector<std::string>& notes) const;

 private:
  std::vector<std::string> simplified_;
  double error_ = 0;  ///< the largest [m]
};

}  // namespace stiction::world
