#pragma once

#include <cmath>
#include <limits>
#include <memory>

#include "stiction/contact/contact.hpp"
#include "stiction/contact/support_table.hpp"

// Internal to the layer: shapes flattened for the kernels. Not installed.

namespace stiction::contact::detail {

using Eigen::Vector3d;
using world::Pose;

inline double sign(double x) { return x < 0 ? -1.0 : 1.0; }

/// Order in which the kernels take their two arguments.
enum class Kind : unsigned char {
  Sphere,
  Capsule,
  Box,
  Cylinder,
  Mesh,
  HalfSpace
};
inline constexpr int kKinds = 6;

/// Vertices, triangles and face planes of a convex mesh, one array per coordinate.
struct MeshData {
  Eigen::Matrix3Xd vertices;  // copy of the mesh's, so that the data outlives the scene
  SupportTable farthest;      // support table of the vertices
  Eigen::Matrix3Xi triangles;
  Eigen::VectorXd nx, ny, nz, d;   // outward plane n·x = d of every triangle that has an area
  std::vector<int> face;           // triangle of each plane
  std::vector<int> around, begin;  // planes around vertex v: around[begin[v]], …, before begin[v + 1]
  Vector3d p_GCenter;              // centre and radius of a bounding sphere
  double radius = 0;
};

/// @throws core::InvalidInput: no vertices or triangles, an index out of range, no triangle with an area
std::shared_ptr<const MeshData> make_mesh_data(const world::ConvexMesh& mesh);

struct Polytope;  // polytope.hpp

struct ShapeData {
  Kind kind = Kind::Sphere;
  double radius = 0;       // sphere, capsule, cylinder
  Vector3d half{0, 0, 0};  // box: half extents; capsule, cylinder: half length in z
  std::shared_ptr<const MeshData> mesh;
  std::shared_ptr<const Polytope> polytope;  // flat faces, of the kinds that have any
  Vector3d p_GCenter{0, 0, 0};               // bounding sphere in the geometry frame
  double bounding_radius = 0;
};

ShapeData make_shape_data(const world::Shape& shape);

/// Same as make_shape_data(), but the tables of a mesh are built once and kept as long as the mesh lives. Building them for one link takes
/// longer than hundreds of steps, and every workspace needs them.
ShapeData find_shape_data(const world::Shape& shape);

/// Radius by which the core of a shape is grown to the shape [m]. The core of a sphere is a point and that of a capsule a segment; any
/// other shape is its own core (radius 0).
inline double core_radius(const ShapeData& s) { return s.kind == Kind::Sphere || s.kind == Kind::Capsule ? s.radius : 0.0; }

/// Vertex of a mesh that is farthest along d, in the frame of the mesh; the first one at a tie.
inline int find_vertex(const MeshData& mesh, const Vector3d& d) {
  return mesh.farthest.find_farthest(d, [&mesh](int i) { return mesh.vertices.col(i); });
}

/// max d·x over the core of a shape at X. For a half-space: d·x of a point of its plane.
inline double core_support(const ShapeData& s, const Pose& X, const Vector3d& d) {
  const Vector3d l = X.R.transpose() * d;
  const double h = d.dot(X.p);
  switch (s.kind) {
    case Kind::Capsule:
      return h + s.half.z() * std::abs(l.z());
    case Kind::Box:
      return h + s.half.dot(l.cwiseAbs());
    case Kind::Cylinder:
      return h + s.half.z() * std::abs(l.z()) + s.radius * std::hypot(l.x(), l.y());
    case Kind::Mesh:
      return h + l.dot(s.mesh->vertices.col(find_vertex(*s.mesh, l)));
    case Kind::Sphere:
    case Kind::HalfSpace:
      break;
  }
  return h;
}

/// max d·x over a shape at X, for |d| = 1.
inline double support(const ShapeData& s, const Pose& X, const Vector3d& d) { return core_support(s, X, d) + core_radius(s); }

/// Set in planar models: if a shape has several nearest faces, faces across the plane are ignored.
struct Planar {
  bool on = false;
  Vector3d axis_W{0, 0, 0};
};

/// Further input of a kernel besides its two shapes.
struct KernelContext {
  Planar planar;
  // The kernel may stop at a separation of at least this [m]; φ and the points may then be inexact.
  double limit = std::numeric_limits<double>::infinity();
};

/// Computes the signed distance of two shapes, kind(a) ≤ kind(b).
using Kernel = void (*)(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, const KernelContext& context,
                        Distance& out);

/// Kernel for two kinds with first ≤ second; nullptr for two half-spaces.
Kernel find_kernel(Kind first, Kind second);

/// Exchanges the roles of A and B.
inline void swap_roles(Distance& d) {
  d.p_WA.swap(d.p_WB);
  d.nhat_BA_W = -d.nhat_BA_W;
}

/// Distance of two spheres. It is inline because it is the most frequent kernel of a hand. For coincident centres, nhat = `fallback`.
inline void sphere_sphere(const Vector3d& p_WA, double r_a, const Vector3d& p_WB, double r_b, const Vector3d& fallback, Distance& out) {
  const Vector3d d = p_WA - p_WB;
  const double length = d.norm();
  out.nhat_BA_W = length > 0 ? Vector3d(d * (1.0 / length)) : fallback;
  out.phi = length - r_a - r_b;
  out.p_WA = p_WA - r_a * out.nhat_BA_W;
  out.p_WB = p_WB + r_b * out.nhat_BA_W;
}

/// Normal for coincident sphere centres: +z, or +x in a planar model whose plane is x–y.
inline Vector3d coincident_normal(const Planar& planar) {
  return planar.on && std::abs(planar.axis_W.z()) > 0.5 ? Vector3d::UnitX() : Vector3d::UnitZ();
}

}  // namespace stiction::contact::detail
