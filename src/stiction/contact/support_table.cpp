#include "stiction/contact/support_table.hpp"

#include <numeric>

namespace stiction::contact::detail {
namespace {

/// Fills the cells of one face of the cube. Each cell takes its list from the larger cell that contains it.
class FaceFiller {
 public:
  FaceFiller(const Eigen::Matrix3Xd& points, int axis, double sign, double near, int n_cells, std::vector<std::vector<int>>& out)
      : points_(points), axis_(axis), sign_(sign), near_(near), n_cells_(n_cells), out_(out) {}

  // The cell of half width h around c contains the directions c + x, with x zero along the axis and at most h along the two others. In this
  // cell v is never farther than w if c · (w − v) ≥ h |w − v|₁, without the component along the axis. Take w as the point farthest along c.
  void fill(int i, int j, int width, const std::vector<int>& from) {
    const int first = (axis_ + 1) % 3, second = (axis_ + 2) % 3;
    const double h = static_cast<double>(width) / n_cells_;
    Eigen::Vector3d c;
    c[axis_] = sign_;
    c[first] = 2.0 * i / n_cells_ + h - 1;
    c[second] = 2.0 * j / n_cells_ + h - 1;
    int w = from.front();
    for (const int v : from) w = c.dot(points_.col(v)) > c.dot(points_.col(w)) ? v : w;
    std::vector<int> here;
    for (const int v : from) {
      const Eigen::Vector3d r = points_.col(w) - points_.col(v);
      if (c.dot(r) <= h * (std::abs(r[first]) + std::abs(r[second])) + near_) here.push_back(v);
    }
    if (width == 1) {
      out_[static_cast<std::size_t>(i * n_cells_ + j)] = std::move(here);
      return;
    }
    const int half = width / 2;
    for (const int down : {0, half}) {
      for (const int right : {0, half}) fill(i + down, j + right, half, here);
    }
  }

 private:
  const Eigen::Matrix3Xd& points_;
  int axis_;
  double sign_, near_;
  int n_cells_;
  std::vector<std::vector<int>>& out_;
};

}  // namespace

SupportTable::SupportTable(const Eigen::Matrix3Xd& points) {
  std::vector<int> all(static_cast<std::size_t>(points.cols()));
  std::iota(all.begin(), all.end(), 0);
  begin_ = {0};
  const auto add = [this](const std::vector<int>& cell) {
    list_.insert(list_.end(), cell.begin(), cell.end());
    begin_.push_back(static_cast<int>(list_.size()));
  };
  if (points.cols() < kFewest) {
    add(all);
    return;
  }
  // The margin kNear of near(), times the length of the longest c + x, and the same again for rounding.
  const double size = 0.5 * (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
  const double near = 2 * std::sqrt(3.0) * kNear * size;
  std::vector<std::vector<int>> cells(static_cast<std::size_t>(kCells * kCells));
  for (int face = 0; face < 6; ++face) {
    FaceFiller(points, face / 2, face % 2 == 0 ? 1.0 : -1.0, near, kCells, cells).fill(0, 0, kCells, all);
    for (const std::vector<int>& cell : cells) add(cell);
  }
}

}  // namespace stiction::contact::detail
