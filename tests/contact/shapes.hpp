#pragma once
// Shapes, poses and an independent picture of convex sets for the tests of the contact layer.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "stiction/contact/contact.hpp"

namespace stiction::contact::test {

using Eigen::Vector3d;
using world::Pose;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double lower, double upper) { return std::uniform_real_distribution<>(lower, upper)(engine_); }
  Vector3d in_cube(double half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }
  Vector3d direction() {
    std::normal_distribution<> n;
    return Vector3d(n(engine_), n(engine_), n(engine_)).normalized();
  }
  Eigen::Matrix3d rotation() {
    std::normal_distribution<> n;
    return Eigen::Quaterniond(n(engine_), n(engine_), n(engine_), n(engine_)).normalized().toRotationMatrix();
  }
  Pose pose(double half) {
    const Eigen::Matrix3d R = rotation();
    return {R, in_cube(half)};
  }

 private:
  std::mt19937 engine_;
};

inline Eigen::Matrix3d turn(double angle, const Vector3d& axis = Vector3d::UnitZ()) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// Irregular octahedron around the origin.
inline world::Mesh make_mesh() {
  auto m = std::make_shared<world::ConvexMesh>();
  m->vertices.resize(3, 6);
  m->vertices << 0.08, -0.07, 0.01, 0, 0.005, 0,  //
      0.01, 0, 0.06, -0.05, 0, -0.01,             //
      0, 0.01, 0, 0.005, 0.05, -0.06;
  m->triangles.resize(3, 8);
  m->triangles << 0, 2, 1, 3, 2, 1, 3, 0,  //
      2, 1, 3, 0, 0, 2, 1, 3,              //
      4, 4, 4, 4, 5, 5, 5, 5;
  return {m};
}

/// A box as a mesh of twelve triangles.
inline world::Mesh make_box_mesh(const Vector3d& half) {
  auto m = std::make_shared<world::ConvexMesh>();
  m->vertices.resize(3, 8);
  for (int i = 0; i < 8; ++i) m->vertices.col(i) = half.cwiseProduct(Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  m->triangles.resize(3, 12);
  m->triangles << 0, 0, 4, 4, 0, 0, 2, 2, 0, 0, 1, 1,  //
      2, 3, 5, 7, 1, 5, 6, 7, 4, 6, 3, 7,              //
      3, 1, 7, 6, 5, 4, 7, 3, 6, 2, 7, 5;
  return {m};
}

struct Named {
  std::string name;
  world::Shape shape;
};

inline std::vector<Named> all_shapes() {
  return {{"sphere", world::Sphere{0.05}},           {"capsule", world::Capsule{0.03, 0.06}}, {"box", world::Box{{0.05, 0.03, 0.08}}},
          {"cylinder", world::Cylinder{0.04, 0.06}}, {"half_space", world::HalfSpace{}},      {"mesh", make_mesh()}};
}

inline bool is_half_space(const world::Shape& s) { return std::holds_alternative<world::HalfSpace>(s); }
/// max over the set of d · x, in W. Infinite for a half-space off its normal.
inline double support(const world::Shape& shape, const Pose& X_WG, const Vector3d& d) {
  const Vector3d l = X_WG.R.transpose() * d;
  const double base = d.dot(X_WG.p);
  if (const auto* s = std::get_if<world::Sphere>(&shape)) return base + s->radius * d.norm();
  if (const auto* s = std::get_if<world::Capsule>(&shape)) return base + s->radius * d.norm() + s->half_length * std::abs(l.z());
  if (const auto* s = std::get_if<world::Box>(&shape)) return base + s->half_extents.dot(l.cwiseAbs());
  if (const auto* s = std::get_if<world::Cylinder>(&shape))
    return base + s->half_length * std::abs(l.z()) + s->radius * std::hypot(l.x(), l.y());
  if (const auto* s = std::get_if<world::Mesh>(&shape)) return base + (l.transpose() * s->mesh->vertices).maxCoeff();
  return (l - Vector3d::UnitZ() * l.norm()).norm() < 1e-12 * std::max(1.0, l.norm()) ? base : std::numeric_limits<double>::infinity();
}

/// How far p sticks out of the set: 0 or less inside, and in absolute value no more than its distance to the surface.
inline double outside(const world::Shape& shape, const Pose& X_WG, const Vector3d& p_W) {
  const Vector3d p = X_WG.R.transpose() * (p_W - X_WG.p);
  if (const auto* s = std::get_if<world::Sphere>(&shape)) return p.norm() - s->radius;
  if (const auto* s = std::get_if<world::Capsule>(&shape)) {
    return (p - Vector3d(0, 0, std::clamp(p.z(), -s->half_length, s->half_length))).norm() - s->radius;
  }
  if (const auto* s = std::get_if<world::Box>(&shape)) return (p.cwiseAbs() - s->half_extents).maxCoeff();
  if (const auto* s = std::get_if<world::Cylinder>(&shape))
    return std::max(p.head<2>().norm() - s->radius, std::abs(p.z()) - s->half_length);
  if (const auto* s = std::get_if<world::Mesh>(&shape)) {
    double most = -1e300;
    for (Eigen::Index i = 0; i < s->mesh->triangles.cols(); ++i) {
      const Vector3d a = s->mesh->vertices.col(s->mesh->triangles(0, i)), b = s->mesh->vertices.col(s->mesh->triangles(1, i)),
                     c = s->mesh->vertices.col(s->mesh->triangles(2, i));
      most = std::max(most, (b - a).cross(c - a).normalized().dot(p - a));
    }
    return most;
  }
  return p.z();
}

/// Width of the gap between A and B along n (from B to A); a lower bound of phi for every unit n, and equal to it for the best.
inline double gap_along(const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB, const Vector3d& n) {
  return -support(a, X_WA, -n) - support(b, X_WB, n);
}

}  // namespace stiction::contact::test
