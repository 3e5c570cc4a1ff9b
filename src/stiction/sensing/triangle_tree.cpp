#include "stiction/sensing/triangle_tree.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "stiction/world/triangle.hpp"

namespace stiction::sensing {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

using detail::V4;

constexpr int kDepth = 32;              ///< a quarter every level: enough for more triangles than there are
constexpr int kStack = 3 * kDepth + 4;  ///< of the four boxes of a node one is entered, three wait on the stack

struct Box {
  Vector3d lower = Vector3d::Constant(std::numeric_limits<double>::infinity()), upper = -lower;
  void add(const Box& other) {
    lower = lower.cwiseMin(other.lower);
    upper = upper.cwiseMax(other.upper);
  }
};

/// Squared distances of p from four boxes.
V4 squared_distances(const Vector3d& p, const std::array<V4, 3>& lower, const std::array<V4, 3>& upper) {
  V4 out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double at = p[static_cast<Eigen::Index>(k)];
    const V4 outside = detail::largest(detail::largest(lower[k] - at, at - upper[k]), V4{});
    out += outside * outside;
  }
  return out;
}

std::size_t find_least(const std::array<double, 4>& x) {
  const std::size_t i = x[1] < x[0] ? 1 : 0, j = x[3] < x[2] ? 3 : 2;
  return x[j] < x[i] ? j : i;
}

}  // namespace

/// Ranges of triangles, halved at the median along the axis in which their centres spread most, until at most four are left.
class TriangleTree::Builder {
 public:
  Builder(const Matrix3Xd& corners, std::vector<int>& order, std::vector<Node>& nodes)
      : corners_(corners), centers_(3, corners.cols() / 3), order_(order), nodes_(nodes) {
    for (Eigen::Index t = 0; t < centers_.cols(); ++t) centers_.col(t) = corners.middleCols<3>(3 * t).rowwise().mean();
    order_.resize(static_cast<std::size_t>(centers_.cols()));
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.reserve(order_.size());
    Box all;
    build(0, static_cast<int>(order_.size()), all);
  }

 private:
  static constexpr int kLanes = 4;

  /// @returns the index of the node of a range  @param box  becomes that of its triangles
  int build(int begin, int end, Box& box) {
    const auto index = nodes_.size();
    Node node;
    node.lower.fill(V4{} + std::numeric_limits<double>::infinity());
    node.upper.fill(V4{} - std::numeric_limits<double>::infinity());
    nodes_.push_back(node);
    int lane = 0;
    const auto add = [&](int child, const Box& part) {
      for (std::size_t k = 0; k < 3; ++k) {
        node.lower[k][lane] = part.lower[static_cast<Eigen::Index>(k)];
        node.upper[k][lane] = part.upper[static_cast<Eigen::Index>(k)];
      }
      node.child[static_cast<std::size_t>(lane++)] = child;
      box.add(part);
    };
    if (end - begin <= kLanes) {
      for (int i = begin; i < end; ++i) add(~i, box_of(order_[static_cast<std::size_t>(i)]));
    } else {
      for (const auto& [first, last] : quarter(begin, end)) {
        if (first == last) continue;
        Box part;
        const int child = build(first, last, part);
        add(child, part);
      }
    }
    nodes_[index] = node;
    return static_cast<int>(index);
  }

  /// Four ranges of a range, of which the second and the last may be empty.
  std::array<std::pair<int, int>, 4> quarter(int begin, int end) {
    const int middle = halve(begin, end);
    const int left = middle - begin > kLanes ? halve(begin, middle) : middle;
    const int right = end - middle > kLanes ? halve(middle, end) : end;
    return {{{begin, left}, {left, middle}, {middle, right}, {right, end}}};
  }

  int halve(int begin, int end) {
    Box spread;
    for (int i = begin; i < end; ++i) {
      const Vector3d center = centers_.col(order_[static_cast<std::size_t>(i)]);
      spread.add({center, center});
    }
    Eigen::Index axis = 0;
    (spread.upper - spread.lower).maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
      return std::pair(centers_(axis, a), a) < std::pair(centers_(axis, b), b);  // no ties: the same tree everywhere
    });
    return middle;
  }

  Box box_of(int t) const {
    return {corners_.middleCols<3>(3 * t).rowwise().minCoeff(), corners_.middleCols<3>(3 * t).rowwise().maxCoeff()};
  }

  const Matrix3Xd& corners_;
  Matrix3Xd centers_;
  std::vector<int>& order_;
  std::vector<Node>& nodes_;
};

TriangleTree::TriangleTree(const Matrix3Xd& corners) {
  const auto n = corners.cols() / 3;
  if (n == 0) return;
  Builder(corners, order_, nodes_);
  corners_.resize(3, 3 * n);
  for (Eigen::Index t = 0; t < n; ++t) corners_.middleCols<3>(3 * t) = corners.middleCols<3>(3 * order_[static_cast<std::size_t>(t)]);
}

TriangleTree::Closest TriangleTree::closest(const Vector3d& p, int guess) const {
  Closest best;
  const auto look = [&](int t) {
    const Vector3d point = world::nearest_on_triangle(p, corner(t, 0), corner(t, 1), corner(t, 2));
    const double squared = (point - p).squaredNorm();
    if (squared < best.squared_distance) best = {t, point, squared};
  };
  if (nodes_.empty()) return best;
  if (guess >= 0) look(guess);
  struct Waiting {
    double bound;
    int child;
  };
  std::array<Waiting, kStack> stack;
  int top = 0, child = 0;
  while (true) {
    if (child < 0) {
      look(~child);
    } else {
      const Node& node = nodes_[static_cast<std::size_t>(child)];
      std::array<double, 4> squared;
      detail::store(squared_distances(p, node.lower, node.upper), squared.data());
      const std::size_t nearest = find_least(squared);
      for (std::size_t lane = 0; lane < 4; ++lane) {  // without branches, which would be unpredictable
        stack[static_cast<std::size_t>(top)] = {squared[lane], node.child[lane]};
        top += static_cast<int>(lane != nearest) & static_cast<int>(squared[lane] < best.squared_distance);
      }
      child = node.child[nearest];
      if (squared[nearest] < best.squared_distance) continue;
    }
    do {
      if (top == 0) return best;
      --top;
    } while (stack[static_cast<std::size_t>(top)].bound >= best.squared_distance);
    child = stack[static_cast<std::size_t>(top)].child;
  }
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

/// Which of four boxes a ray meets.
auto meets_boxes(const Vector3d& p, const Vector3d& inverse, const std::array<V4, 3>& lower, const std::array<V4, 3>& upper) {
  V4 near{}, far = V4{} + std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const double at = p[static_cast<Eigen::Index>(k)], by = inverse[static_cast<Eigen::Index>(k)];
    const V4 t0 = (lower[k] - at) * by, t1 = (upper[k] - at) * by;
    const V4 first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
    const auto bounded = t0 + t1 == t0 + t1;  // not of a ray in the plane of a side, 0 ∞, or across this axis between the sides, −∞ + ∞
    near = bounded & (first > near) ? first : near;
    far = bounded & (last < far) ? last : far;
  }
  return near <= far;
}

}  // namespace

bool TriangleTree::is_hit(const Vector3d& p, const Vector3d& d) const {
  if (nodes_.empty()) return false;
  const Vector3d inverse = d.cwiseInverse();
  std::array<int, kStack> stack;
  int top = 0;
  stack[0] = 0;
  while (top >= 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[static_cast<std::size_t>(top--)])];
    const auto met = meets_boxes(p, inverse, node.lower, node.upper);
    for (int lane = 0; lane < 4; ++lane) {
      const int child = node.child[static_cast<std::size_t>(lane)];
      if (!met[lane] || node.lower[0][lane] > node.upper[0][lane]) continue;
      if (child >= 0)
        stack[static_cast<std::size_t>(++top)] = child;
      else if (meets(p, d, corner(~child, 0), corner(~child, 1), corner(~child, 2)))
        return true;
    }
  }
  return false;
}

}  // namespace stiction::sensing
