#include "stiction/sensing/surface.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/blue_noise.hpp"
#include "stiction/sensing/tessellate.hpp"
#include "stiction/sensing/trim.hpp"
#include "stiction/sensing/visibility.hpp"

namespace stiction::sensing {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

/// Triangles of all geometry of a body in its frame, and edges of its files that do not border two of them.
struct Faces {
  Matrix3Xd corners;
  int open_edges = 0;
};

/// A file that came in several convex parts counts once.
Faces collect_faces(const world::Model& model, int body, int segments) {
  std::vector<Matrix3Xd> pieces;
  std::set<const Matrix3Xd*> seen;
  Eigen::Index corners = 0;
  Faces out;
  for (const auto& geometry : model.geometries()) {
    if (geometry.body != body) continue;
    const auto* mesh = std::get_if<world::Mesh>(&geometry.shape);
    const Matrix3Xd* file = mesh != nullptr ? mesh->mesh->surface.get() : nullptr;
    if (file != nullptr && !seen.insert(file).second) continue;
    const Matrix3Xd triangles = tessellate(geometry.shape, segments);
    if (file != nullptr) out.open_edges += count_open_edges(triangles);
    pieces.push_back((geometry.X_BG.R * triangles).colwise() + geometry.X_BG.p);
    corners += triangles.cols();
  }
  out.corners.resize(3, corners);
  Eigen::Index at = 0;
  for (const Matrix3Xd& piece : pieces) {
    out.corners.middleCols(at, piece.cols()) = piece;
    at += piece.cols();
  }
  return out;
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
  out.size = calc_diagonal(corners);
  const Eigen::Index n = out.tree.size();
  out.normals.resize(3, n);
  out.areas_below.resize(n);
  for (Eigen::Index t = 0; t < n; ++t) {
    const Vector3d area = calc_area_vector(out.tree.corners(), t);
    out.normals.col(t) = area.normalized();
    out.area += area.norm();
    out.areas_below[t] = out.area;
  }
  out.corner_normals = smooth_normals(out.tree.corners(), out.normals, crease);
  return out;
}

void add_notes(const std::string& name, const Faces& all, const Trimmed& trimmed, std::vector<std::string>& notes) {
  if (trimmed.turned + trimmed.flat + trimmed.hidden > 0)
    notes.push_back(fmt::format("{}: of {} triangles {} are left out as hidden and {} as flat, {} are turned around", name,
                                all.corners.cols() / 3, trimmed.hidden, trimmed.flat, trimmed.turned));
  if (all.open_edges > 0)
    notes.push_back(
        fmt::format("{}: {} edges do not border two triangles: its surface is open or folded, and is used as it is", name, all.open_edges));
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

Surfaces make_surfaces(const world::Model& model, std::span<const int> bodies, const SurfaceOptions& options, HiddenLinks hidden) {
  options.validate();
  std::vector<TriangleTree> trees(model.bodies().size());
  std::vector<Faces> faces(model.bodies().size());
  for (std::size_t body = 0; body < model.bodies().size(); ++body) {
    if (model.bodies()[body].kind != world::BodyKind::Robot) continue;
    faces[body] = collect_faces(model, static_cast<int>(body), options.segments);
    trees[body] = TriangleTree(faces[body].corners);
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
    const Faces& all = faces[static_cast<std::size_t>(body)];
    Trimmed trimmed;
    if (all.corners.cols() > 0) trimmed = trim(all.corners, body, visibility, options.cache_dir);
    if (trimmed.corners.cols() == 0) {
      const auto triangles = all.corners.cols() / 3;
      if (hidden == HiddenLinks::Refuse)
        core::throw_invalid("links", fmt::format("'{}', of whose {} triangles {} are hidden", info.name, triangles, trimmed.hidden),
                            "links with a surface that can be touched");
      out.notes.push_back(
          fmt::format("{}: {} of its {} triangles are hidden in the robot and none can be touched, so that no contact is looked for on it",
                      info.name, trimmed.hidden, triangles));
      continue;
    }
    add_notes(info.name, all, trimmed, out.notes);
    out.links.push_back(make_surface(body, trimmed.corners, options.crease));
  }
  if (out.links.empty() && !bodies.empty())
    core::throw_invalid("links", "links whose triangles are all hidden", "links with a surface that can be touched");
  return out;
}

namespace {

/// Selects the points that lie farthest apart from several points per sample.
std::vector<SurfacePoint> spread_samples(const Surface& surface, int count, std::uint64_t seed) {
  constexpr int kSeveral = 5;
  const std::vector<SurfacePoint> many = sample_surface(surface, kSeveral * count, Sampling::Stratified, seed);
  Matrix3Xd points(3, static_cast<Eigen::Index>(many.size()));
  for (std::size_t i = 0; i < many.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = many[i].p_L;
  std::vector<SurfacePoint> out;
  for (const int i : eliminate_samples(points, count, surface.area)) out.push_back(many[static_cast<std::size_t>(i)]);
  return out;
}

}  // namespace

std::vector<SurfacePoint> sample_surface(const Surface& surface, int count, Sampling sampling, std::uint64_t seed) {
  if (sampling == Sampling::BlueNoise) return spread_samples(surface, count, seed);
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
