#include "stiction/sensing/triangle_tree.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "stiction/contact/triangle.hpp"

namespace stiction::sensing {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

constexpr int kLeaf = 4;    ///< triangles
constexpr int kDepth = 64;  ///< halved every level: enough for more triangles than there are

double squared_distance(const Vector3d& p, const Vector3d& lower, const Vector3d& upper) {
  return (lower - p).cwiseMax(p - upper).cwiseMax(0.0).squaredNorm();
}

}  // namespace

TriangleTree::TriangleTree(const Matrix3Xd& corners) {
  const auto n = static_cast<int>(corners.cols() / 3);
  if (n == 0) return;
  Matrix3Xd centers(3, n);
  for (int t = 0; t < n; ++t) centers.col(t) = corners.middleCols<3>(3 * t).rowwise().mean();
  order_.resize(static_cast<std::size_t>(n));
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(static_cast<std::size_t>(2 * n));
  build(order_, 0, n, corners, centers);
  corners_.resize(3, 3 * n);
  for (int t = 0; t < n; ++t) corners_.middleCols<3>(3 * t) = corners.middleCols<3>(3 * order_[static_cast<std::size_t>(t)]);
}

int TriangleTree::build(std::vector<int>& order, int begin, int end, const Matrix3Xd& corners, const Matrix3Xd& centers) {
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Vector3d lower = Vector3d::Constant(std::numeric_limits<double>::infinity()), upper = -lower;
  Vector3d low_center = lower, high_center = upper;
  for (int i = begin; i < end; ++i) {
    const int t = order[static_cast<std::size_t>(i)];
    lower = lower.cwiseMin(corners.middleCols<3>(3 * t).rowwise().minCoeff());
    upper = upper.cwiseMax(corners.middleCols<3>(3 * t).rowwise().maxCoeff());
    low_center = low_center.cwiseMin(centers.col(t));
    high_center = high_center.cwiseMax(centers.col(t));
  }
  nodes_[static_cast<std::size_t>(index)] = {lower, upper, begin, end - begin};
  if (end - begin <= kLeaf) return index;

  Eigen::Index axis = 0;
  (high_center - low_center).maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end, [&](int a, int b) {
    return std::pair(centers(axis, a), a) < std::pair(centers(axis, b), b);  // no ties: the same tree everywhere
  });
  build(order, begin, middle, corners, centers);
  const int right = build(order, middle, end, corners, centers);
  nodes_[static_cast<std::size_t>(index)].first = right;
  nodes_[static_cast<std::size_t>(index)].count = 0;
  return index;
}

TriangleTree::Closest TriangleTree::closest(const Vector3d& p, int guess) const {
  Closest best;
  const auto look = [&](int t) {
    const Vector3d point = contact::nearest_on_triangle(p, corner(t, 0), corner(t, 1), corner(t, 2));
    const double squared = (point - p).squaredNorm();
    if (squared < best.squared_distance) best = {t, point, squared};
  };
  if (nodes_.empty()) return best;
  if (guess >= 0) look(guess);
  std::array<std::pair<double, int>, kDepth> stack;
  int top = 0;
  stack[top++] = {squared_distance(p, nodes_[0].lower, nodes_[0].upper), 0};
  while (top > 0) {
    const auto [bound, index] = stack[--top];
    if (bound >= best.squared_distance) continue;
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (node.count > 0) {
      for (int t = node.first; t < node.first + node.count; ++t) look(t);
      continue;
    }
    const Node &left = nodes_[static_cast<std::size_t>(index + 1)], &right = nodes_[static_cast<std::size_t>(node.first)];
    std::pair near{squared_distance(p, left.lower, left.upper), index + 1};
    std::pair far{squared_distance(p, right.lower, right.upper), node.first};
    if (far.first < near.first) std::swap(near, far);
    if (far.first < best.squared_distance) stack[top++] = far;
    if (near.first < best.squared_distance) stack[top++] = near;
  }
  return best;
}

namespace {

/// Möller and Trumbore 1997, both sides, t > 0.
bool meets(const Vector3d& p, const Vector3d& d, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, h = d.cross(ac);
  const double det = ab.dot(h);
  if (det == 0) return false;
  const Vector3d ap = p - a;
  const double u = ap.dot(h) / det;
  if (!(u >= 0 && u <= 1)) return false;
  const Vector3d g = ap.cross(ab);
  const double v = d.dot(g) / det;
  return v >= 0 && u + v <= 1 && ac.dot(g) / det > 0;
}

bool meets_box(const Vector3d& p, const Vector3d& inverse, const Vector3d& lower, const Vector3d& upper) {
  double near = 0, far = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double t0 = (lower[k] - p[k]) * inverse[k], t1 = (upper[k] - p[k]) * inverse[k];
    near = std::max(near, std::min(t0, t1));  // NaN, of a ray in the plane of a side, leaves the bounds
    far = std::min(far, std::max(t0, t1));
  }
  return near <= far;
}

}  // namespace

bool TriangleTree::is_hit(const Vector3d& p, const Vector3d& d) const {
  if (nodes_.empty()) return false;
  const Vector3d inverse = d.cwiseInverse();
  std::array<int, kDepth> stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const int index = stack[--top];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (!meets_box(p, inverse, node.lower, node.upper)) continue;
    if (node.count == 0) {
      stack[top++] = node.first;
      stack[top++] = index + 1;
      continue;
    }
    for (int t = node.first; t < node.first + node.count; ++t)
      if (meets(p, d, corner(t, 0), corner(t, 1), corner(t, 2))) return true;
  }
  return false;
}

}  // namespace stiction::sensing
