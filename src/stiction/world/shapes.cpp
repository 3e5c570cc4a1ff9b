#include "stiction/world/shapes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"

namespace stiction::world {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

Matrix3d parallel_axis(double m, const Vector3d& d) { return m * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose()); }

namespace {

VolumeProperties calc_mesh_properties(const ConvexMesh& mesh) {
  // Sum of the tetrahedra (reference point, triangle); the second moment of each about the reference is exact.
  const Vector3d reference = mesh.vertices.rowwise().mean();
  double volume = 0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t) {
    Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = mesh.vertices.col(mesh.triangles(k, t)) - reference;
    const double v = corners.determinant() / 6;
    const Vector3d sum = corners.rowwise().sum();
    volume += v;
    first += v / 4 * sum;
    second += v / 20 * (corners * corners.transpose() + sum * sum.transpose());
  }
  const Vector3d c = first / volume;
  const Matrix3d about_center = second - volume * c * c.transpose();
  return {volume, reference + c, about_center.trace() * Matrix3d::Identity() - about_center};
}

void require_mesh(const std::string& field, const ConvexMesh* mesh) {
  if (mesh == nullptr || mesh->vertices.cols() < 4 || mesh->triangles.cols() < 4)
    core::throw_invalid(field, "fewer than 4 vertices or triangles", "a closed convex mesh");
  const std::string what = mesh->source.empty() ? field : fmt::format("{} ({})", field, mesh->source);
  const auto n = mesh->vertices.cols();
  std::set<std::array<double, 3>> points;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3d v = mesh->vertices.col(i);
    if (!v.allFinite()) core::throw_invalid(what, fmt::format("vertex {} that is not finite", i), "finite vertices");
    if (!points.insert({v[0], v[1], v[2]}).second)
      core::throw_invalid(what, fmt::format("vertex {} at the point ({}, {}, {}) of another", i, v[0], v[1], v[2]), "each vertex once");
  }
  for (Eigen::Index t = 0; t < mesh->triangles.cols(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int index = mesh->triangles(k, t);
      if (index < 0 || index >= n)
        core::throw_invalid(what, fmt::format("triangle {} with vertex {}", t, index), fmt::format("vertices 0 to {}", n - 1));
    }
  }
  const double volume = calc_mesh_properties(*mesh).volume;
  if (!(volume > 0)) core::throw_invalid(what, fmt::format("volume {:.3g}", volume), "a volume > 0 (triangles that wind outwards)");
}

}  // namespace

std::string_view shape_name(const Shape& shape) {
  static constexpr std::string_view kNames[] = {"sphere", "capsule", "box", "cylinder", "half_space", "mesh"};
  return kNames[shape.index()];
}

Matrix3d rotation_from_rpy(const Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy[2], Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy[1], Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy[0], Vector3d::UnitX()))
      .toRotationMatrix();
}

VolumeProperties calc_volume_properties(const Shape& shape) {
  const auto about_z = [](double volume, double xx, double zz) {
    return VolumeProperties{volume, Vector3d::Zero(), Vector3d(xx, xx, zz).asDiagonal()};
  };
  return std::visit(
      core::Overloaded{
          [&](const Sphere& s) {
            const double v = 4.0 / 3.0 * pi * std::pow(s.radius, 3);
            return about_z(v, 0.4 * v * s.radius * s.radius, 0.4 * v * s.radius * s.radius);
          },
          [&](const Capsule& s) {
            const double r = s.radius, l = 2 * s.half_length;
            const double tube = pi * r * r * l, ball = 4.0 / 3.0 * pi * r * r * r;
            const double xx = tube * (l * l / 12 + r * r / 4) + ball * (0.4 * r * r + l * l / 4 + 3 * l * r / 8);
            return about_z(tube + ball, xx, tube * r * r / 2 + 0.4 * ball * r * r);
          },
          [&](const Box& s) {
            const Vector3d size2 = (2 * s.half_extents).cwiseAbs2();
            const double v = 8 * s.half_extents.prod();
            return VolumeProperties{v, Vector3d::Zero(), (v / 12 * (Vector3d::Constant(size2.sum()) - size2)).asDiagonal()};
          },
          [&](const Cylinder& s) {
            const double r = s.radius, l = 2 * s.half_length, v = pi * r * r * l;
            return about_z(v, v * (3 * r * r + l * l) / 12, v * r * r / 2);
          },
          [](const HalfSpace&) -> VolumeProperties { core::throw_invalid("shape", "a half-space", "a shape with a finite volume"); },
          [](const Mesh& s) { return calc_mesh_properties(*s.mesh); },
      },
      shape);
}

VolumeProperties calc_volume_properties(std::span<const GeometrySpec> geometries) {
  VolumeProperties all;
  std::vector<VolumeProperties> parts;
  for (const auto& geometry : geometries) {
    VolumeProperties part = calc_volume_properties(geometry.shape);
    part.center = geometry.X_BG * part.center;
    part.inertia = (geometry.X_BG.R * part.inertia * geometry.X_BG.R.transpose()).eval();
    all.volume += part.volume;
    all.center += part.volume * part.center;
    parts.push_back(part);
  }
  if (parts.empty()) return all;
  all.center /= all.volume;
  for (const auto& part : parts) all.inertia += part.inertia + parallel_axis(part.volume, part.center - all.center);
  return all;
}

BoundingSphere calc_bounding_sphere(const Shape& shape) {
  return std::visit(core::Overloaded{
                        [](const Sphere& s) {
                          return BoundingSphere{Vector3d::Zero(), s.radius};
                        },
                        [](const Capsule& s) {
                          return BoundingSphere{Vector3d::Zero(), s.radius + s.half_length};
                        },
                        [](const Box& s) {
                          return BoundingSphere{Vector3d::Zero(), s.half_extents.norm()};
                        },
                        [](const Cylinder& s) {
                          return BoundingSphere{Vector3d::Zero(), std::hypot(s.radius, s.half_length)};
                        },
                        [](const HalfSpace&) {
                          return BoundingSphere{Vector3d::Zero(), std::numeric_limits<double>::infinity()};
                        },
                        [](const Mesh& s) {
                          const auto& v = s.mesh->vertices;
                          const Vector3d center = (v.rowwise().minCoeff() + v.rowwise().maxCoeff()) / 2;
                          return BoundingSphere{center, (v.colwise() - center).colwise().norm().maxCoeff()};
                        },
                    },
                    shape);
}

void require_shape(std::string_view field, const Shape& shape) {
  const auto need = [&](std::string_view part, double value) { core::require_positive(fmt::format("{}.{}", field, part), value); };
  std::visit(core::Overloaded{
                 [&](const Sphere& s) { need("radius", s.radius); },
                 [&](const Capsule& s) { need("radius", s.radius), need("half_length", s.half_length); },
                 [&](const Box& s) {
                   for (int i = 0; i < 3; ++i) need("half_extents", s.half_extents[i]);
                 },
                 [&](const Cylinder& s) { need("radius", s.radius), need("half_length", s.half_length); },
                 [](const HalfSpace&) {},
                 [&](const Mesh& s) { require_mesh(fmt::format("{}.mesh", field), s.mesh.get()); },
             },
             shape);
}

}  // namespace stiction::world
