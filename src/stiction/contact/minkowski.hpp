#pragma once

#include <array>

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: distance and depth of two convex cores by their Minkowski difference C = A − B. docs/theory/distance.md §5.

namespace stiction::contact::detail {

/// A point of C and the points of the two cores of which it is the difference, in the axes of A.
struct Corner {
  Vector3d w, a, b;  // w = a − b
  int i = 0, j = 0;  // corners of the two cores; −1 on a rim
  bool is(const Corner& o) const { return i >= 0 && j >= 0 ? i == o.i && j == o.j : w == o.w; }
};

/// The cores of two shapes, both expressed in the frame of A.
class Minkowski {
 public:
  Minkowski(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB);

  /// The corner of C that is farthest along d (not 0).
  void find_farthest(const Vector3d& d, Corner& out) const;
  /// max d·w over C.
  double height(const Vector3d& d) const {
    Corner c;
    find_farthest(d, c);
    return d.dot(c.w);
  }
  /// From the centre of B to that of A.
  Vector3d line() const { return a_.p_GCenter - (R_ * b_.p_GCenter + p_); }
  double size() const { return a_.bounding_radius + b_.bounding_radius; }

  const ShapeData& a() const { return a_; }
  const ShapeData& b() const { return b_; }
  const Eigen::Matrix3d& R_AB() const { return R_; }

 private:
  const ShapeData &a_, &b_;
  Eigen::Matrix3d R_;
  Vector3d p_;
};

/// Up to four corners of C and the weights of a point of their hull.
struct Simplex {
  std::array<Corner, 4> corner;
  std::array<double, 4> weight{1, 0, 0, 0};
  int n = 0;
};

/// Finds the point v ≠ 0 of C nearest to the origin, and the simplex in which v lies (GJK). It stops when no point of C is nearer by more
/// than `tolerance` [m], or when C is at least `enough` [m] away in the direction of v.
/// @returns false if the origin lies in C; then it lies in `simplex`, up to rounding
bool find_nearest(const Minkowski& c, double tolerance, double enough, Simplex& simplex, Vector3d& v);

/// Finds the shortest way from the origin out of C (EPA). On entry the origin lies in `simplex`, up to rounding. It stops when no point of
/// C lies beyond the result by more than `tolerance` [m]. On return `simplex` has the corners around the point on the boundary, and m is
/// the outward unit normal there.
/// @returns false if it ended early for lack of storage or digits; the result is then the best so far
bool find_way_out(const Minkowski& c, double tolerance, Simplex& simplex, Vector3d& m);

}  // namespace stiction::contact::detail
