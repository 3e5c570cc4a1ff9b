#pragma once

#include <string>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Allowed distance between simplified and original hulls of a robot's meshes, as a share of the mesh diagonal: 0.5 mm for a link of 0.25 m.
inline constexpr double kHullTolerance = 2e-3;

struct SimplifiedHull {
  ConvexMesh mesh;   ///< hull of the corners that are kept; it lies inside the given mesh
  double error = 0;  ///< Hausdorff distance between the two [m]
};

/// Removes corners of a convex mesh as long as its surface moves by at most `tolerance` [m]. The cost of contact queries grows with the number
/// of corners, and files have thousands of them on round surfaces.
///
/// The hull starts with a few corners. The corners farthest outside are added until none is farther from the hull than the tolerance. Equal
/// meshes give equal results.
/// @throws core::InvalidInput: tolerance negative or not finite
/// Tests: tests/world/simplify_hull_test.cpp
SimplifiedHull simplify_hull(const ConvexMesh& mesh, double tolerance);

/// The same with a tolerance relative to the diagonal of the mesh, such as kHullTolerance.
SimplifiedHull simplify_hull_by_share(const ConvexMesh& mesh, double share);

/// Collects the meshes of one robot's links that lost corners, for a note.
class LinkHulls {
 public:
  /// @param error  distance between its two hulls [m]
  void add(double error, const std::string& name);

  /// Adds a note on which surfaces moved and how far; no note if none moved.
  void add_note(std::vector<std::string>& notes) const;

 private:
  std::vector<std::string> simplified_;
  double error_ = 0;  ///< the largest error [m]
};

}  // namespace stiction::world
