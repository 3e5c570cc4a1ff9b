#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>

#include "stiction/contact/closed_form.hpp"
#include "stiction/contact/core_distance.hpp"
#include "stiction/contact/polytope.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact {
namespace detail {

std::shared_ptr<const MeshData> make_mesh_data(const world::ConvexMesh& mesh) {
  auto out = std::make_shared<MeshData>();
  const Eigen::Index n_v = mesh.vertices.cols(), n_t = mesh.triangles.cols();
  if (n_v == 0 || n_t == 0) core::throw_invalid("mesh", fmt::format("{} vertices and {} triangles", n_v, n_t), "a closed convex surface");
  out->vertices = mesh.vertices;
  out->farthest = SupportTable(mesh.vertices);
  out->triangles = mesh.triangles;
  const Vector3d lower = mesh.vertices.rowwise().minCoeff(), upper = mesh.vertices.rowwise().maxCoeff();
  out->p_GCenter = 0.5 * (lower + upper);
  for (Eigen::Index i = 0; i < n_v; ++i) out->radius = std::max(out->radius, (mesh.vertices.col(i) - out->p_GCenter).norm());
  std::vector<Eigen::Vector4d> planes;
  for (Eigen::Index i = 0; i < n_t; ++i) {
    const Eigen::Vector3i tri = mesh.triangles.col(i);
    if (tri.minCoeff() < 0 || tri.maxCoeff() >= n_v) {
      core::throw_invalid(fmt::format("mesh.triangles[{}]", i), fmt::format("[{}, {}, {}]", tri[0], tri[1], tri[2]),
                          fmt::format("vertex indices from 0 to {}", n_v - 1));
    }
    const Vector3d p = mesh.vertices.col(tri[0]);
    const Vector3d cross = (mesh.vertices.col(tri[1]) - p).cross(mesh.vertices.col(tri[2]) - p);
    if (cross.norm() <= 1e-14 * out->radius * out->radius) continue;  // a sliver has no reliable plane
    const Vector3d n = cross.normalized();
    planes.emplace_back(n.x(), n.y(), n.z(), n.dot(p));
    out->face.push_back(static_cast<int>(i));
  }
  std::vector<std::vector<int>> around(static_cast<std::size_t>(n_v));
  for (std::size_t k = 0; k < out->face.size(); ++k) {
    for (int i = 0; i < 3; ++i) around[static_cast<std::size_t>(mesh.triangles(i, out->face[k]))].push_back(static_cast<int>(k));
  }
  out->begin = {0};
  for (const std::vector<int>& planes_of : around) {
    out->around.insert(out->around.end(), planes_of.begin(), planes_of.end());
    out->begin.push_back(static_cast<int>(out->around.size()));
  }
  const auto n_f = static_cast<Eigen::Index>(planes.size());
  if (n_f == 0) core::throw_invalid("mesh.triangles", "only triangles without area", "a closed convex surface");
  out->nx.resize(n_f);
  out->ny.resize(n_f);
  out->nz.resize(n_f);
  out->d.resize(n_f);
  for (Eigen::Index i = 0; i < n_f; ++i) {
    out->nx[i] = planes[i][0];
    out->ny[i] = planes[i][1];
    out->nz[i] = planes[i][2];
    out->d[i] = planes[i][3];
  }
  return out;
}

namespace {

struct Flatten {
  ShapeData out;

  void operator()(const world::Sphere& s) {
    out.kind = Kind::Sphere;
    out.radius = out.bounding_radius = s.radius;
  }
  void operator()(const world::Capsule& s) {
    out.kind = Kind::Capsule;
    out.radius = s.radius;
    out.half.z() = s.half_length;
    out.bounding_radius = s.radius + s.half_length;
  }
  void operator()(const world::Box& s) {
    out.kind = Kind::Box;
    out.half = s.half_extents;
    out.bounding_radius = s.half_extents.norm();
  }
  void operator()(const world::Cylinder& s) {
    out.kind = Kind::Cylinder;
    out.radius = s.radius;
    out.half.z() = s.half_length;
    out.bounding_radius = std::hypot(s.radius, s.half_length);
  }
  void operator()(const world::HalfSpace&) {
    out.kind = Kind::HalfSpace;
    out.bounding_radius = std::numeric_limits<double>::infinity();
  }
  void operator()(const world::Mesh& s) {
    out.kind = Kind::Mesh;
    if (!s.mesh) core::throw_invalid("mesh", "nothing", "a convex mesh");
    out.mesh = make_mesh_data(*s.mesh);
    out.p_GCenter = out.mesh->p_GCenter;
    out.bounding_radius = out.mesh->radius;
  }
};

}  // namespace

ShapeData make_shape_data(const world::Shape& shape) {
  Flatten flatten;
  std::visit(flatten, shape);
  flatten.out.polytope = make_polytope(flatten.out);
  return flatten.out;
}

ShapeData find_shape_data(const world::Shape& shape) {
  const auto* mesh = std::get_if<world::Mesh>(&shape);
  if (mesh == nullptr || !mesh->mesh) return make_shape_data(shape);
  static std::mutex mutex;
  static std::map<std::weak_ptr<const world::ConvexMesh>, ShapeData, std::owner_less<>> made;
  const std::lock_guard lock(mutex);
  if (const auto seen = made.find(mesh->mesh); seen != made.end()) return seen->second;
  std::erase_if(made, [](const auto& entry) { return entry.first.expired(); });
  return made.emplace(mesh->mesh, make_shape_data(shape)).first->second;
}

Kernel find_kernel(Kind first, Kind second) {
  // Rows and columns: sphere, capsule, box, cylinder, mesh, half-space.
  static constexpr std::array<std::array<Kernel, kKinds>, kKinds> table{{
      {sphere_sphere_kernel, sphere_capsule_kernel, sphere_box_kernel, sphere_cylinder_kernel, sphere_mesh_kernel, sphere_halfspace_kernel},
      {nullptr, capsule_capsule_kernel, core_distance, core_distance, core_distance, capsule_halfspace_kernel},
      {nullptr, nullptr, box_box_kernel, core_distance, core_distance, box_halfspace_kernel},
      {nullptr, nullptr, nullptr, core_distance, core_distance, cylinder_halfspace_kernel},
      {nullptr, nullptr, nullptr, nullptr, core_distance, mesh_halfspace_kernel},
      {nullptr, nullptr, nullptr, nullptr, nullptr, nullptr},
  }};
  return table[static_cast<int>(first)][static_cast<int>(second)];
}

}  // namespace detail

Distance calc_distance(const world::Shape& a, const world::Pose& X_WA, const world::Shape& b, const world::Pose& X_WB) {
  const detail::ShapeData data_a = detail::make_shape_data(a), data_b = detail::make_shape_data(b);
  const bool swapped = data_b.kind < data_a.kind;
  const detail::Kernel kernel = swapped ? find_kernel(data_b.kind, data_a.kind) : find_kernel(data_a.kind, data_b.kind);
  if (!kernel) core::throw_invalid("shapes", "two half-spaces", "at most one half-space in a pair");
  const detail::KernelContext context;
  Distance out;
  if (swapped) {
    kernel(data_b, X_WB, data_a, X_WA, context, out);
    detail::swap_roles(out);
  } else {
    kernel(data_a, X_WA, data_b, X_WB, context, out);
  }
  return out;
}

}  // namespace stiction::contact
