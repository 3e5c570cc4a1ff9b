#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "stiction/sensing/four.hpp"

namespace stiction::sensing {

/// Triangles in a tree of axis-aligned boxes, four to a node, in an array of nodes. Immutable, shared by threads; queries use no heap.
/// Measured against Coal's tree in bench/sensing_bench.cpp.
class TriangleTree {
 public:
  struct Closest {
    int triangle = -1;  ///< −1: none within the bound
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    double squared_distance = std::numeric_limits<double>::infinity();
  };

  TriangleTree() = default;
  /// @param corners  (3 × 3n), finite; triangles are reordered so that neighbours in space are adjacent
  explicit TriangleTree(const Eigen::Matrix3Xd& corners);

  int size() const { return static_cast<int>(corners_.cols() / 3); }
  Eigen::Vector3d corner(int triangle, int k) const { return corners_.col(3 * triangle + k); }
  const Eigen::Matrix3Xd& corners() const { return corners_; }  ///< (3 × 3n) in the order of this tree
  const std::vector<int>& order() const { return order_; }      ///< index of each triangle in the given corners

  /// Nearest point of all triangles. @param guess  a triangle that is probably near, or −1
  Closest closest(const Eigen::Vector3d& p, int guess = -1) const;

  /// Whether the ray p + t d meets a triangle at t > 0, from either side.
  bool is_hit(const Eigen::Vector3d& p, const Eigen::Vector3d& d) const;

 private:
  /// Up to four boxes at a time, around triangles or around further nodes.
  struct Node {
    std::array<detail::V4, 3> lower, upper;  ///< by axis; ∞ and −∞ in unused lanes
    std::array<int, 4> child{};              ///< node ≥ 0, or ~triangle
  };
  class Builder;

  Eigen::Matrix3Xd corners_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace stiction::sensing
