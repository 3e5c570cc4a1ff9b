#include "stiction/sensing/surface.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/tessellate.hpp"
#include "stiction/sensing/visibility.hpp"

namespace stiction::sensing {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

/// Triangles of all geometry of a body in its frame; a file that came in several convex parts once.
Matrix3Xd collect_triangles(const world::Model& model, int body, int segments) {
  std::vector<Matrix3Xd> pieces;
  std::set<const Matrix3Xd*> seen;
  Eigen::Index corners = 0;
  for (const auto& geometry : model.geometries()) {
    if (geometry.body != body) continue;
    if (const auto* mesh = std::get_if<world::Mesh>(&geometry.shape)) {
      const Matrix3Xd* file = mesh->mesh->surface.get();
      if (file != nullptr && !seen.insert(file).second) continue;
    }
    const Matrix3Xd triangles = tessellate(geometry.shape, segments);
    pieces.push_back((geometry.X_BG.R * triangles).colwise() + geometry.X_BG.p);
    corners += triangles.cols();
  }
  Matrix3Xd out(3, corners);
  Eigen::Index at = 0;
  for (const Matrix3Xd& piece : pieces) {
    out.middleCols(at, piece.cols()) = piece;
    at += piece.cols();
  }
  return out;
}

Vector3d area_vector(const Matrix3Xd& corners, Eigen::Index t) {
  const Vector3d a = corners.col(3 * t), b = corners.col(3 * t + 1), c = corners.col(3 * t + 2);
  return 0.5 * (b - a).cross(c - a);
}

double diagonal(const Matrix3Xd& points) { return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm(); }

/// What became of the triangles of a link.
struct Counts {
  int kept = 0, turned = 0, hidden = 0, flat = 0;
};

/// The triangles that are seen, wound so that they are seen from where their normals point.
Matrix3Xd trim(const Matrix3Xd& corners, int body, const Visibility* visibility, Counts& counts) {
  constexpr double kFlat = 1e-12;  // share of the squared size: an area that rounding makes
  const double size = diagonal(corners), lift = 1e-6 * size;
  std::vector<Vector3d> out;
  for (Eigen::Index t = 0; t < corners.cols() / 3; ++t) {
    const Vector3d area = area_vector(corners, t);
    if (!(area.norm() > kFlat * size * size)) {
      ++counts.flat;
      continue;
    }
    const Vector3d n = area.normalized(), center = corners.middleCols<3>(3 * t).rowwise().mean();
    const auto is_seen = [&](const Vector3d& direction) {
      if (visibility->is_seen(body, center, direction, lift)) return true;
      for (int k = 0; k < 3; ++k)
        if (visibility->is_seen(body, center + 0.9 * (corners.col(3 * t + k) - center), direction, lift)) return true;
      return false;
    };
    bool turn = false;
    if (visibility != nullptr && !is_seen(n)) {
      turn = visibility->is_seen(body, center, -n, lift);
      if (!turn) {
        ++counts.hidden;
        continue;
      }
      ++counts.turned;
    }
    ++counts.kept;
    for (const int k : {0, turn ? 2 : 1, turn ? 1 : 2}) out.push_back(corners.col(3 * t + k));
  }
  Matrix3Xd kept(3, static_cast<Eigen::Index>(out.size()));
  for (std::size_t i = 0; i < out.size(); ++i) kept.col(static_cast<Eigen::Index>(i)) = out[i];
  return kept;
}

/// Per corner the mean of the normals around it, weighted by angles, of triangles that meet this one at less than the crease.
Matrix3Xd smooth_normals(const Matrix3Xd& corners, const Matrix3Xd& normals, double crease) {
  std::map<std::array<double, 3>, std::vector<Eigen::Index>> around;
  const auto key = [&](Eigen::Index i) { return std::array<double, 3>{corners(0, i), corners(1, i), corners(2, i)}; };
  for (Eigen::Index i = 0; i < corners.cols(); ++i) around[key(i)].push_back(i);
  const auto angle = [&](Eigen::Index i) {
    const Eigen::Index t = i / 3 * 3, k = i % 3;
    const Vector3d u = corners.col(t + (k + 1) % 3) - corners.col(i), v = corners.col(t + (k + 2) % 3) - corners.col(i);
    return std::atan2(u.cross(v).norm(), u.dot(v));
  };
  Matrix3Xd out(3, corners.cols());
  const double least = std::cos(crease);
  for (Eigen::Index i = 0; i < corners.cols(); ++i) {
    const Vector3d n = normals.col(i / 3);
    Vector3d sum = Vector3d::Zero();
    for (const Eigen::Index j : around.at(key(i)))
      if (n.dot(normals.col(j / 3)) >= least) sum += angle(j) * normals.col(j / 3);
    out.col(i) = sum.normalized();
  }
  return out;
}

Surface make_surface(int body, const Matrix3Xd& corners, double crease) {
  Surface out;
  out.body = body;
  out.tree = TriangleTree(corners);
  out.size = diagonal(corners);
  const Eigen::Index n = out.tree.size();
  out.normals.resize(3, n);
  out.areas_below.resize(n);
  for (Eigen::Index t = 0; t < n; ++t) {
    const Vector3d area = area_vector(out.tree.corners(), t);
    out.normals.col(t) = area.normalized();
    out.area += area.norm();
    out.areas_below[t] = out.area;
  }
  out.corner_normals = smooth_normals(out.tree.corners(), out.normals, crease);
  return out;
}

}  // namespace

void SurfaceOptions::validate() const {
  if (segments < 3) core::throw_invalid("segments", fmt::format("{}", segments), "an integer ≥ 3");
  if (rays < 0) core::throw_invalid("rays", fmt::format("{}", rays), "an integer ≥ 0");
  if (postures < 1) core::throw_invalid("postures", fmt::format("{}", postures), "an integer ≥ 1");
  core::require_nonnegative("crease", crease);
}

Vector3d Surface::normal(int triangle, const Vector3d& p, Normals kind) const {
  if (kind == Normals::Flat) return normals.col(triangle);
  // Barycentric coordinates of p, as ratios of signed areas.
  const Vector3d a = tree.corner(triangle, 0), b = tree.corner(triangle, 1), c = tree.corner(triangle, 2);
  const Vector3d n = (b - a).cross(c - a);
  const double scale = n.squaredNorm();
  const double u = (c - b).cross(p - b).dot(n) / scale, v = (a - c).cross(p - c).dot(n) / scale;
  return (u * corner_normals.col(3 * triangle) + v * corner_normals.col(3 * triangle + 1) +
          (1 - u - v) * corner_normals.col(3 * triangle + 2))
      .normalized();
}

Surfaces make_surfaces(const world::Model& model, std::span<const int> bodies, const SurfaceOptions& options) {
  options.validate();
  std::vector<TriangleTree> trees(model.bodies().size());
  std::vector<Matrix3Xd> triangles(model.bodies().size());
  for (std::size_t body = 0; body < model.bodies().size(); ++body) {
    if (model.bodies()[body].kind != world::BodyKind::Robot) continue;
    triangles[body] = collect_triangles(model, static_cast<int>(body), options.segments);
    trees[body] = TriangleTree(triangles[body]);
  }
  std::map<int, Visibility> visibilities;  // of each robot
  Surfaces out;
  for (const int body : bodies) {
    const auto& info = model.bodies()[static_cast<std::size_t>(body)];
    if (info.kind != world::BodyKind::Robot) core::throw_invalid("links", "'" + info.name + "'", "links of robots");
    const Visibility* visibility = nullptr;
    if (options.rays > 0)
      visibility =
          &visibilities.try_emplace(info.owner, model, info.owner, trees, options.rays, options.postures, options.seed).first->second;
    Counts counts;
    const Matrix3Xd& all = triangles[static_cast<std::size_t>(body)];
    const Matrix3Xd kept = all.cols() > 0 ? trim(all, body, visibility, counts) : all;
    if (kept.cols() == 0) {
      core::throw_invalid("links", fmt::format("'{}', of whose {} triangles {} are hidden", info.name, all.cols() / 3, counts.hidden),
                          "links with a surface that can be touched");
    }
    if (counts.turned + counts.flat + counts.hidden > 0) {
      out.notes.push_back(fmt::format("{}: of {} triangles {} are left out as hidden and {} as flat, {} are turned around", info.name,
                                      all.cols() / 3, counts.hidden, counts.flat, counts.turned));
    }
    out.links.push_back(make_surface(body, kept, options.crease));
  }
  return out;
}

std::vector<SurfacePoint> sample_surface(const Surface& surface, int count, Sampling sampling, std::uint64_t seed) {
  core::Random random(seed, static_cast<std::uint64_t>(surface.body));
  std::vector<SurfacePoint> out(static_cast<std::size_t>(count));
  const double* const areas = surface.areas_below.data();
  for (int i = 0; i < count; ++i) {
    const double share = sampling == Sampling::Uniform ? random.uniform() : (i + random.uniform()) / count;
    const auto* found = std::upper_bound(areas, areas + surface.areas_below.size(), share * surface.area);
    const int t = std::min(static_cast<int>(found - areas), surface.tree.size() - 1);
    const double u = std::sqrt(random.uniform()), v = random.uniform();  // uniform in the triangle
    out[static_cast<std::size_t>(i)] = {
        t, (1 - u) * surface.tree.corner(t, 0) + u * (1 - v) * surface.tree.corner(t, 1) + u * v * surface.tree.corner(t, 2)};
  }
  return out;
}

}  // namespace stiction::sensing
