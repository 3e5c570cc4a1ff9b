#include "stiction/world/simplify_hull.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/triangle.hpp"

namespace stiction::world {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

/// A round also adds the farthest corner of each other face, if its distance is more than this share of the largest distance.
constexpr double kAlike = 0.5;

/// Faces of a hull as planes n·x ≤ d.
struct Planes {
  Matrix3Xd normals;
  Eigen::VectorXd offsets;

  explicit Planes(const ConvexMesh& hull) : normals(3, hull.triangles.cols()), offsets(hull.triangles.cols()) {
    for (Index t = 0; t < hull.triangles.cols(); ++t) {
      const Vector3d a = corner(hull, t, 0);
      normals.col(t) = (corner(hull, t, 1) - a).cross(corner(hull, t, 2) - a).stableNormalized();
      offsets[t] = normals.col(t).dot(a);
    }
  }
  /// Largest distance by which a point is outside a face; negative if it is inside all faces. @param face  receives that face
  double outside(const Vector3d& p, Index* face) const { return (normals.transpose() * p - offsets).maxCoeff(face); }
  static Vector3d corner(const ConvexMesh& hull, Index t, int k) { return hull.vertices.col(hull.triangles(k, t)); }
};

/// Chooses the corners farthest along the axes and their diagonals. Their hull has a volume if the whole mesh has one.
std::vector<char> choose_first(const Matrix3Xd& corners) {
  std::vector<char> chosen(static_cast<std::size_t>(corners.cols()), 0);
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        Index i = 0;
        (Vector3d(x, y, z).transpose() * corners).maxCoeff(&i);
        chosen[static_cast<std::size_t>(i)] = 1;
      }
    }
  }
  return chosen;
}

std::optional<ConvexMesh> make_hull(const Matrix3Xd& corners, const std::vector<char>& chosen) {
  std::vector<Index> which;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i]) which.push_back(static_cast<Index>(i));
  try {
    return make_convex_hull(corners(Eigen::all, which));
  } catch (const core::InvalidInput&) {
    return std::nullopt;  // flat
  }
}

/// Chooses the corners that are farthest outside faces, by more than the tolerance. @returns whether there were any
bool choose_outside(const Matrix3Xd& corners, const Planes& planes, double tolerance, std::vector<char>& chosen) {
  std::vector<std::pair<double, Index>> farthest(static_cast<std::size_t>(planes.offsets.size()), {0, -1});
  double most = 0;
  for (Index i = 0; i < corners.cols(); ++i) {
    if (chosen[static_cast<std::size_t>(i)]) continue;
    Index face = 0;
    const double outside = planes.outside(corners.col(i), &face);
    auto& best = farthest[static_cast<std::size_t>(face)];
    if (outside > best.first) best = {outside, i};
    most = std::max(most, outside);
  }
  if (most <= tolerance) return false;
  for (const auto& [outside, i] : farthest)
    if (outside > std::max(tolerance, kAlike * most)) chosen[static_cast<std::size_t>(i)] = 1;
  return true;
}

double calc_distance(const ConvexMesh& hull, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (Index t = 0; t < hull.triangles.cols(); ++t) {
    const Vector3d q = nearest_on_triangle(p, Planes::corner(hull, t, 0), Planes::corner(hull, t, 1), Planes::corner(hull, t, 2));
    least = std::min(least, (q - p).norm());
  }
  return least;
}

/// Chooses corners that are farther from the hull than the tolerance though not from any plane, as happens at sharp edges.
/// @returns the largest distance of the other corners [m]
double choose_far(const Matrix3Xd& corners, const ConvexMesh& hull, const Planes& planes, double tolerance, std::vector<char>& chosen,
                  bool& any) {
  double error = 0;
  any = false;
  Index face = 0;
  for (Index i = 0; i < corners.cols(); ++i) {
    if (chosen[static_cast<std::size_t>(i)] || planes.outside(corners.col(i), &face) <= 0) continue;
    const double distance = calc_distance(hull, corners.col(i));
    if (distance > tolerance)
      chosen[static_cast<std::size_t>(i)] = 1, any = true;
    else
      error = std::max(error, distance);
  }
  return error;
}

}  // namespace

SimplifiedHull simplify_hull(const ConvexMesh& mesh, double tolerance) {
  core::require_nonnegative("tolerance", tolerance);
  std::vector<char> chosen = choose_first(mesh.vertices);
  for (;;) {
    std::optional<ConvexMesh> hull = make_hull(mesh.vertices, chosen);
    if (!hull) return {mesh, 0};
    const Planes planes(*hull);
    if (choose_outside(mesh.vertices, planes, tolerance, chosen)) continue;
    bool any = false;
    const double error = choose_far(mesh.vertices, *hull, planes, tolerance, chosen, any);
    if (any) continue;
    hull->source = mesh.source;
    hull->surface = mesh.surface;
    return {std::move(*hull), error};
  }
}

SimplifiedHull simplify_hull_by_share(const ConvexMesh& mesh, double share) {
  const double diagonal = (mesh.vertices.rowwise().maxCoeff() - mesh.vertices.rowwise().minCoeff()).norm();
  return simplify_hull(mesh, share * diagonal);
}

void LinkHulls::add(double error, const std::string& name) {
  if (error > 0 && std::find(simplified_.begin(), simplified_.end(), name) == simplified_.end()) simplified_.push_back(name);
  error_ = std::max(error_, error);
}

void LinkHulls::add_note(std::vector<std::string>& notes) const {
  if (simplified_.empty()) return;
  notes.push_back(fmt::format("corners of the hulls of meshes are left out, which moves their surfaces by up to {:.2g} mm: {}",
                              1e3 * error_, list_some(simplified_)));
}

}  // namespace stiction::world
