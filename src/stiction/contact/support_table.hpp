#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

// Internal to the layer: the farthest of many points along a direction, by a table over directions. docs/theory/contact.md §6.

namespace stiction::contact::detail {

/// Which of many points may be the farthest along a direction. The directions are cut into cells, squares on the faces of a cube, each
/// with the points that may count in it.
class SupportTable {
 public:
  /// A point that is nearer than this share of the size of the set (half the diagonal of its bounding box) to the farthest counts too [-].
  static constexpr double kNear = 1e-6;

  SupportTable() = default;
  explicit SupportTable(const Eigen::Matrix3Xd& points);

  /// Indices, in ascending order, of some of the points, with every i for which d · p_i ≥ max_k d · p_k − kNear ‖d‖ size. Any d.
  std::span<const int> near(const Eigen::Vector3d& d) const {
    const std::size_t cell = begin_.size() > 2 ? find_cell(d) : 0;
    return {list_.data() + begin_[cell], list_.data() + begin_[cell + 1]};
  }

  /// Of the points, point(i), the farthest along d; of several the first.
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
  static constexpr int kCells = 8;    // along an edge of the cube, a power of two
  static constexpr int kFewest = 12;  // below, one cell does

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
