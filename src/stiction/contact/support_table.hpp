#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

// Internal to the layer: the farthest of many points along a direction, by a table over directions. docs/theory/contact.md §6.

namespace stiction::contact::detail {

/// Table that finds the farthest of many points along a direction. Directions are divided into cells, squares on the faces of a cube. Each
/// cell lists the points that may be the farthest for its directions.
class SupportTable {
 public:
  /// Points whose height is within this share of the size of the set (half the diagonal of its bounding box) of the largest are listed too
  /// [-].
  static constexpr double kNear = 1e-6;

  SupportTable() = default;
  explicit SupportTable(const Eigen::Matrix3Xd& points);

  /// Indices of the listed points for any d, in ascending order. They include every i with d · p_i ≥ max_k d · p_k − kNear ‖d‖ size.
  std::span<const int> near(const Eigen::Vector3d& d) const {
    const std::size_t cell = begin_.size() > 2 ? find_cell(d) : 0;
    return {list_.data() + begin_[cell], list_.data() + begin_[cell + 1]};
  }

  /// Index of the point that is farthest along d, the first one at a tie. point(i) gives the points.
  template <class Point>
  int find_farthest(const Eigen::Vector3d& d, const Point& point) const {
    int best = 0;
    double most = -std::numeric_limits<double>::infinity();
    for (const int i : near(d)) {
      const double height = d.dot(point(i));
      if (height > most) most = height, best = i;
    }
    return best;
  }

 private:
  static constexpr int kCells = 8;    // number of cells along an edge of the cube, a power of two
  static constexpr int kFewest = 12;  // sets with fewer points have one cell only

  static std::size_t find_cell(const Eigen::Vector3d& d) {
    const Eigen::Vector3d a = d.cwiseAbs();
    const int axis = a.x() >= a.y() ? (a.x() >= a.z() ? 0 : 2) : (a.y() >= a.z() ? 1 : 2);
    const double scale = 0.5 * kCells / a[axis];
    const auto along = [&](int k) {
      const double x = 0.5 * kCells + scale * d[k];
      return !(x > 0) ? 0 : x < kCells ? static_cast<int>(x) : kCells - 1;
    };
    const int face = 2 * axis + (d[axis] < 0 ? 1 : 0);
    return static_cast<std::size_t>((face * kCells + along((axis + 1) % 3)) * kCells + along((axis + 2) % 3));
  }

  std::vector<int> begin_{0, 0}, list_;
};

}  // namespace stiction::contact::detail
