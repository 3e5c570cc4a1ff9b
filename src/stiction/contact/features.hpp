#pragma once

#include <array>

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: vertices, edges, faces, rims and generators of a shape near a direction, equation (6) of docs/theory/distance.md.

namespace stiction::contact::detail {

constexpr int kMostFeatures = 24;

// A piece of the boundary of a convex core (for a capsule, of its axis). Its support points for directions d near a given one are
// point + Σ c_k dir_k, |c_k| ≤ half_k, + rim · P d / ‖P d‖, where P projects onto the plane perpendicular to rim_axis.
struct Feature {
  Vector3d point{0, 0, 0};
  int n_dirs = 0;
  Vector3d dir[2] = {Vector3d::Zero(), Vector3d::Zero()};
  double half[2] = {0, 0};
  bool disc = false;  // the two c_k lie in a circle of radius half[0]
  double rim = 0;
  Vector3d rim_axis{0, 0, 1};
  Vector3d normal{0, 0, 0};        // outward normal of a face (n_dirs = 2)
  const MeshData* mesh = nullptr;  // mesh of a mesh face; the mesh bounds the c_k
  const Pose* X_WG = nullptr;

  Vector3d radial(const Vector3d& d) const {
    // Projects twice, because the first difference keeps few digits if d is near the axis.
    const Vector3d u = (d - rim_axis * rim_axis.dot(d)).normalized();
    return (u - rim_axis * rim_axis.dot(u)).normalized();
  }
  Vector3d support(const Vector3d& d) const { return rim > 0 ? Vector3d(point + rim * radial(d)) : point; }
};

/// Features in the order in which they are tried. Features that contain the point `at` come first: corners and rims, then edges, then
/// faces. The others follow by increasing distance. If there are too many, the last are left out.
class Features {
 public:
  Features() = default;
  /// @param at  point on the boundary of the core, to within `same` [m]
  Features(const Vector3d& at, double same) : at_(at), same_(same), sorted_(true) {}

  void add(const Feature& f);
  int size() const { return n_; }
  const Feature& operator[](int i) const { return list_[place_[i]]; }

 private:
  double rank(const Feature& f) const;

  Vector3d at_{0, 0, 0};
  double same_ = 0;
  bool sorted_ = false;  // if false, features stay in the order of add()
  int n_ = 0;
  std::array<Feature, kMostFeatures> list_;
  std::array<int, kMostFeatures> place_;
  std::array<double, kMostFeatures> rank_;
};

/// Finds the features of the core of a shape whose normals lie within `near` [rad] of d for a mesh, and within 0.05 rad for other shapes.
void find_features(const ShapeData& s, const Pose& X, const Vector3d& d, double near, Features& out);

}  // namespace stiction::contact::detail
