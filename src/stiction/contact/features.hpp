#pragma once

#include <array>

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: vertices, edges, faces, rims and generators of a shape near a direction, equation (6) of docs/theory/distance.md.

namespace stiction::contact::detail {

constexpr int kMostFeatures = 24;

// A piece of the boundary of a convex core (a capsule counts as its axis), as its set of support points for directions d near
// one: point + Σ c_k dir_k, |c_k| ≤ half_k, + rim · P d / ‖P d‖ with P the projection square to rim_axis.
struct Feature {
  Vector3d point{0, 0, 0};
  int n_dirs = 0;
  Vector3d dir[2] = {Vector3d::Zero(), Vector3d::Zero()};
  double half[2] = {0, 0};
  bool disc = false;  // the two c_k lie in a circle of radius half[0]
  double rim = 0;
  Vector3d rim_axis{0, 0, 1};
  Vector3d normal{0, 0, 0};        // outward, of a face (n_dirs = 2)
  const MeshData* mesh = nullptr;  // of a face of a mesh, which bounds the c_k
  const Pose* X_WG = nullptr;

  Vector3d radial(const Vector3d& d) const {
    // Twice, because for d near the axis the first difference keeps few digits.
    const Vector3d u = (d - rim_axis * rim_axis.dot(d)).normalized();
    return (u - rim_axis * rim_axis.dot(u)).normalized();
  }
  Vector3d support(const Vector3d& d) const { return rim > 0 ? Vector3d(point + rim * radial(d)) : point; }
};

/// Features in the order in which they are tried: those that a point lies on first, of these corners and rims before edges before faces,
/// then the others, the nearest first. Of too many the last are left out.
class Features {
 public:
  Features() = default;
  /// @param at  of the boundary of the core, to within `same` [m]
  Features(const Vector3d& at, double same) : at_(at), same_(same), sorted_(true) {}

  void add(const Feature& f);
  int size() const { return n_; }
  const Feature& operator[](int i) const { return list_[place_[i]]; }

 private:
  double rank(const Feature& f) const;

  Vector3d at_{0, 0, 0};
  double same_ = 0;
  bool sorted_ = false;  // otherwise in the order of add()
  int n_ = 0;
  std::array<Feature, kMostFeatures> list_;
  std::array<int, kMostFeatures> place_;
  std::array<double, kMostFeatures> rank_;
};

/// Features of the core of a shape whose normals lie within `near` [rad] of d: of a mesh; of the other shapes within 0.05 rad.
void find_features(const ShapeData& s, const Pose& X, const Vector3d& d, double near, Features& out);

}  // namespace stiction::contact::detail
