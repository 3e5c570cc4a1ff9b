#include "stiction/contact/polytope.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace stiction::contact::detail {
namespace {

/// A triangle is merged with a face if its corners are this near to the plane of the face, as a share of the bounding radius [-]: mesh
/// files hold floats of seven digits.
constexpr double kCoplanar = 1e-6;

/// Corners of the convex hull of points in the plane of `face`, anticlockwise (monotone chain). Corners in line with their neighbours are
/// left out.
std::vector<int> hull_loop(const std::vector<Vector3d>& vertices, const Polytope::Face& face, std::vector<int> points, double tolerance) {
  const auto x = [&](int i) { return Eigen::Vector2d(face.e1.dot(vertices[i]), face.e2.dot(vertices[i])); };
  std::sort(points.begin(), points.end(), [&](int i, int j) {
    const Eigen::Vector2d a = x(i), b = x(j);
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  const auto turns_left = [&](int i, int j, int k) {
    const Eigen::Vector2d a = x(i), u = x(j) - a, v = x(k) - a;
    return u.x() * v.y() - u.y() * v.x() > tolerance * v.norm();
  };
  std::vector<int> loop;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t first = loop.size();
    for (const int i : points) {
      while (loop.size() >= first + 2 && !turns_left(loop[loop.size() - 2], loop.back(), i)) loop.pop_back();
      loop.push_back(i);
    }
    loop.pop_back();  // it is the first corner of the other half
    std::reverse(points.begin(), points.end());
  }
  return loop;
}

void set_basis(Polytope::Face& face) {
  face.e1 = face.normal.unitOrthogonal();
  face.e2 = face.normal.cross(face.e1);
}

void add_face(Polytope& out, Polytope::Face face, const std::vector<int>& loop) {
  if (loop.size() < 3) return;
  face.begin = static_cast<int>(out.loop.size());
  face.count = static_cast<int>(loop.size());
  out.loop.insert(out.loop.end(), loop.begin(), loop.end());
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Vector3d p = out.vertices[loop[k]], along = out.vertices[loop[(k + 1) % loop.size()]] - p;
    const Eigen::Vector2d s = Eigen::Vector2d(face.e2.dot(along), -face.e1.dot(along)).normalized();
    out.sides.emplace_back(s.x(), s.y(), s.x() * face.e1.dot(p) + s.y() * face.e2.dot(p));
  }
  out.faces.push_back(face);
}

Polytope make_box(const Vector3d& half) {
  Polytope out;
  for (int i = 0; i < 8; ++i) out.vertices.push_back(half.cwiseProduct(Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  for (int axis = 0; axis < 3; ++axis) {
    const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, up = 1 << axis;
    for (const int sign : {-1, 1}) {
      Polytope::Face face;
      face.normal = sign * Vector3d::Unit(axis);
      face.e1 = Vector3d::Unit((axis + 1) % 3);
      face.e2 = sign * Vector3d::Unit((axis + 2) % 3);
      face.d = half[axis];
      const int at = sign > 0 ? up : 0;
      add_face(out, face, sign > 0 ? std::vector<int>{at, at | u, at | u | v, at | v} : std::vector<int>{at, at | v, at | u | v, at | u});
    }
  }
  return out;
}

// The loop starts at the same angle as the fixed points of the cap, so that both are fixed in the body.
Polytope make_caps(double radius, double half) {
  Polytope out;
  for (const double sign : {-1.0, 1.0}) {
    Polytope::Face face;
    face.normal = sign * Vector3d::UnitZ();
    face.e1 = Vector3d::UnitX();
    face.e2 = sign * Vector3d::UnitY();
    face.d = half;
    std::vector<int> loop;
    for (int k = 0; k < kCapCorners; ++k) {
      const double angle = 2 * std::numbers::pi * k / kCapCorners;
      loop.push_back(static_cast<int>(out.vertices.size()));
      out.vertices.push_back(radius * (std::cos(angle) * face.e1 + std::sin(angle) * face.e2) + half * face.normal);
    }
    add_face(out, face, loop);
  }
  return out;
}

// The body is convex, so all triangles in one supporting plane belong to one face.
Polytope make_faces(const MeshData& mesh) {
  Polytope out;
  for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i) out.vertices.emplace_back(mesh.vertices.col(i));
  std::vector<std::size_t> order(mesh.face.size());
  std::iota(order.begin(), order.end(), 0);
  const auto corner = [&](std::size_t i, int k) -> const Vector3d& { return out.vertices[mesh.triangles(k, mesh.face[i])]; };
  const auto area = [&](std::size_t i) { return (corner(i, 1) - corner(i, 0)).cross(corner(i, 2) - corner(i, 0)).norm(); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return area(i) > area(j); });
  std::vector<char> taken(mesh.face.size(), 0);
  const double tolerance = kCoplanar * mesh.radius;
  for (const std::size_t i : order) {
    if (taken[i]) continue;
    const auto k = static_cast<Eigen::Index>(i);
    Polytope::Face face;
    face.normal = Vector3d(mesh.nx[k], mesh.ny[k], mesh.nz[k]);
    face.d = (face.normal.transpose() * mesh.vertices).maxCoeff();
    set_basis(face);
    std::vector<int> points;
    for (std::size_t v = 0; v < out.vertices.size(); ++v) {
      if (std::abs(face.normal.dot(out.vertices[v]) - mesh.d[k]) <= tolerance) points.push_back(static_cast<int>(v));
    }
    for (std::size_t j = 0; j < mesh.face.size(); ++j) {
      if (taken[j]) continue;
      taken[j] = j == i;
      bool flat = face.normal.dot(Vector3d(mesh.nx[static_cast<Eigen::Index>(j)], mesh.ny[static_cast<Eigen::Index>(j)],
                                           mesh.nz[static_cast<Eigen::Index>(j)])) > 0;
      for (int c = 0; c < 3; ++c) flat = flat && std::abs(face.normal.dot(corner(j, c)) - mesh.d[k]) <= tolerance;
      if (flat) taken[j] = 1;
    }
    add_face(out, face, hull_loop(out.vertices, face, points, tolerance));
  }
  return out;
}

std::shared_ptr<const Polytope> index(const ShapeData& s, Polytope polytope) {
  const std::size_t n_f = polytope.faces.size(), n_v = polytope.vertices.size();
  const Eigen::Map<const Eigen::Matrix3Xd> vertices(polytope.vertices.front().data(), 3, static_cast<Eigen::Index>(n_v));
  Eigen::Matrix3Xd normals(3, static_cast<Eigen::Index>(n_f));
  std::vector<std::vector<int>> around(n_v);
  for (std::size_t i = 0; i < n_f; ++i) {
    const Polytope::Face& face = polytope.faces[i];
    normals.col(static_cast<Eigen::Index>(i)) = face.normal;
    for (int k = 0; k < face.count; ++k) around[static_cast<std::size_t>(polytope.loop[face.begin + k])].push_back(static_cast<int>(i));
  }
  polytope.farthest = s.mesh ? s.mesh->farthest : SupportTable(vertices);
  polytope.steepest = SupportTable(normals);
  polytope.begin = {0};
  for (const std::vector<int>& faces : around) {
    polytope.around.insert(polytope.around.end(), faces.begin(), faces.end());
    polytope.begin.push_back(static_cast<int>(polytope.around.size()));
  }
  return std::make_shared<const Polytope>(std::move(polytope));
}

}  // namespace

std::shared_ptr<const Polytope> make_polytope(const ShapeData& s) {
  switch (s.kind) {
    case Kind::Box:
      return index(s, make_box(s.half));
    case Kind::Cylinder:
      return index(s, make_caps(s.radius, s.half.z()));
    case Kind::Mesh:
      return index(s, make_faces(*s.mesh));
    case Kind::Sphere:
    case Kind::Capsule:
    case Kind::HalfSpace:
      break;
  }
  return nullptr;
}

int find_face(const Polytope& polytope, const Vector3d& d) {
  return polytope.steepest.find_farthest(d, [&polytope](int i) -> const Vector3d& { return polytope.faces[i].normal; });
}

int find_vertex(const Polytope& polytope, const Vector3d& d) {
  return polytope.farthest.find_farthest(d, [&polytope](int i) -> const Vector3d& { return polytope.vertices[i]; });
}

}  // namespace stiction::contact::detail
