#include "stiction/contact/workspace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/contact/core_distance.hpp"
#include "stiction/core/invalid_input.hpp"

// Data of a Workspace that is computed before the first query: shapes, pairs in runs, columns of their Jacobians, storage for results.

namespace stiction::contact {

using detail::Kind;
using Eigen::Vector3d;

namespace {

constexpr int kPadding = 8;  // vector loads may run past the last geometry

}  // namespace

/// Lists the runs of axes that move both bodies or one of them. Of two axes that move a body, the axis nearer to the root comes first.
void Workspace::Impl::add_columns(const world::Model& model, const world::Pair& p, PairData& data) {
  const auto axes_of = [&](int geometry) -> const std::vector<int>& { return model.bodies()[model.geometries()[geometry].body].axes; };
  const std::vector<int>&axes_a = axes_of(p.geometry_a), &axes_b = axes_of(p.geometry_b), &support = model.supports()[p.support];
  const auto has = [](const std::vector<int>& list, int axis) { return std::find(list.begin(), list.end(), axis) != list.end(); };
  std::vector<int> all = axes_a;
  for (const int axis : axes_b) {
    if (!has(axes_a, axis)) all.push_back(axis);
  }
  data.n_columns = static_cast<int>(support.size());
  data.n_axes = static_cast<int>(all.size());
  data.folded = std::any_of(all.begin(), all.end(), [&](int axis) { return axis >= n_v; });
  if (!data.folded) all = support;
  data.run_begin = static_cast<int>(column_runs.size());
  for (int c = 0; c < data.n_axes; ++c) {
    const int axis = all[c];
    const bool in_a = has(axes_a, axis), in_b = has(axes_b, axis);
    const bool first = static_cast<int>(column_runs.size()) == data.run_begin;
    if (!first && column_runs.back().axis + column_runs.back().count == axis && column_runs.back().moves_a == in_a &&
        column_runs.back().moves_b == in_b) {
      ++column_runs.back().count;
    } else {
      column_runs.push_back({c, axis, 1, in_a, in_b});
    }
  }
  data.run_end = static_cast<int>(column_runs.size());
  data.fold_begin = static_cast<int>(folds.size());
  if (!data.folded) return;
  for (const int axis : all) {
    const auto column = std::lower_bound(support.begin(), support.end(), axes[axis].dof) - support.begin();
    folds.push_back({static_cast<int>(column), axes[axis].ratio});
  }
  unfolded.resize(std::max(unfolded.size(), 3 * all.size()));
}

namespace {

void add_geometries(const world::Model& model, Workspace::Impl& w) {
  w.geometries.reserve(model.geometries().size());
  for (const world::Geometry& g : model.geometries()) {
    Workspace::Impl::GeometryData data{g.body, {}, g.X_BG, detail::find_shape_data(g.shape), {}};
    data.p_BCenter = g.X_BG * data.shape.p_GCenter;
    if (data.shape.kind != Kind::Sphere) w.posed.push_back(static_cast<int>(w.geometries.size()));
    w.geometries.push_back(std::move(data));
  }
}

/// Chooses how a pair is measured, from the shapes of the pair. @throws core::InvalidInput: two half-spaces
Workspace::Impl::PairData make_pair_data(const world::Model& model, int index, const Workspace::Impl& w) {
  const world::Pair& p = model.pairs()[static_cast<std::size_t>(index)];
  Workspace::Impl::PairData data;
  data.a = p.geometry_a;
  data.b = p.geometry_b;
  const detail::ShapeData &a = w.geometries[data.a].shape, &b = w.geometries[data.b].shape;
  const bool swapped = b.kind < a.kind;
  data.first = swapped ? data.b : data.a;
  data.second = swapped ? data.a : data.b;
  data.friction = p.friction;
  data.radius_a = a.radius;
  data.radius_b = b.radius;
  data.half_space = std::max(a.kind, b.kind) == Kind::HalfSpace ? data.first : -1;
  data.patch = detail::has_patch(w.geometries[data.first].shape, w.geometries[data.second].shape);
  data.boxes = a.kind == Kind::Box && b.kind == Kind::Box;
  data.in_slabs = w.geometries[data.second].shape.kind == Kind::Box && !model.planar_axis();
  if (a.kind == Kind::Sphere && b.kind == Kind::Sphere) return data;
  data.kernel = detail::find_kernel(std::min(a.kind, b.kind), std::max(a.kind, b.kind));
  data.hulls = data.kernel == detail::core_distance;
  if (data.kernel) return data;
  const auto name = [&](int geometry) { return model.geometries()[static_cast<std::size_t>(geometry)].name; };
  core::throw_invalid(fmt::format("pairs[{}]", index), fmt::format("two half-spaces '{}' and '{}'", name(data.a), name(data.b)),
                      "at most one half-space in a pair");
}

/// Adds pair `index` to the runs of pairs that share a geometry.
void extend_runs(const Workspace::Impl::PairData& pair, int index, std::vector<Workspace::Impl::BroadRun>& runs) {
  const bool extends = !runs.empty() && runs.back().fixed == pair.a && runs.back().other + runs.back().count == pair.b;
  if (extends)
    ++runs.back().count;
  else
    runs.push_back({index, 1, pair.a, pair.b});
}

/// Reserves storage for intermediate results, so that queries use no heap.
void reserve_answers(Workspace::Impl& w) {
  const std::size_t n_g = w.geometries.size(), n_p = w.pairs.size();
  for (auto* center : {&w.center_x, &w.center_y, &w.center_z}) center->assign(n_g + kPadding, 0.0);
  w.X_WG.resize(n_g);
  w.placed.resize(n_g);
  w.parting.assign(n_p, Vector3d::UnitX());
  for (auto* values : {&w.center_distance2, &w.excess, &w.center_distance, &w.center_inverse}) values->assign(n_p + kPadding, 0.0);
  w.left_out.assign(n_p, 0.0);
  w.candidates.assign(n_p + kPadding, 0);
  w.screw.assign(8 * w.axes.size(), 0.0);
}

}  // namespace

Workspace::Impl::Impl(const world::Model& model) : n_v(model.n_v()), planar_axis(model.planar_axis()) {
  if (planar_axis) context.planar = {true, Vector3d::Unit(*planar_axis)};
  coincident_normal = detail::coincident_normal(context.planar);
  add_geometries(model, *this);
  for (int i = 0; i < n_v; ++i) axes.push_back({model.dofs()[i].kind == world::DofKind::Revolute, i, 1.0});
  for (const world::Follower& f : model.followers()) axes.push_back({f.kind == world::DofKind::Revolute, f.dof, f.ratio});
  const auto model_pairs = model.pairs();
  pairs.reserve(model_pairs.size());
  for (int i = 0; i < static_cast<int>(model_pairs.size()); ++i) {
    PairData data = make_pair_data(model, i, *this);
    radius_sum.push_back(geometries[data.a].shape.bounding_radius + geometries[data.b].shape.bounding_radius);
    max_distance.push_back(model_pairs[i].max_distance);
    extend_runs(data, i, broad_runs);
    add_columns(model, model_pairs[i], data);
    pairs.push_back(data);
  }
  reserve_answers(*this);
  if (planar_axis) find_planes(model);
  for (std::size_t i = 0; i < pairs.size(); ++i) n_patch_points += static_cast<std::size_t>(slots(static_cast<int>(i)) - 1);
  nearest.reserve(pairs.size() + std::min(n_patch_points, kReservedContacts));
  reserve_scratch();
}

// In a planar model two shapes with centres in one plane overlap exactly as their sections do: the shortest way out stays in the plane.
// Bodies turn about the axis across the plane only, so one configuration shows which shapes are straight along this axis.
void Workspace::Impl::find_planes(const world::Model& model) {
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, model.neutral(), work, kinematics);
  set_kinematics(kinematics);
  double longest = 0;
  for (const GeometryData& g : geometries) {
    if (g.shape.kind != Kind::HalfSpace) longest = std::max(longest, g.shape.bounding_radius);
  }
  for (const int i : posed) {
    GeometryData& g = geometries[i];
    g.extruded = g.shape;
    for (int k = 0; k < 3; ++k) {
      const bool straight = g.shape.kind == Kind::Box || (k == 2 && (g.shape.kind == Kind::Cylinder || g.shape.kind == Kind::Capsule));
      if (straight && std::abs(X_WG[i].R(*planar_axis, k)) > 1.0 - 1e-9) g.extruded.half[k] += 10.0 * longest;
    }
    g.extruded.polytope = detail::make_polytope(g.extruded);
  }
  const std::vector<double>& height = *planar_axis == 0 ? center_x : *planar_axis == 1 ? center_y : center_z;
  for (PairData& p : pairs) {
    p.in_plane = std::abs(height[p.a] - height[p.b]) < 1e-9 * longest;
    if (!p.in_plane && p.half_space < 0) p.patch = false;
  }
}

void Workspace::Impl::reserve_scratch() {
  std::size_t most = 2 * detail::kCapPoints, vertices = 0;
  for (const GeometryData& g : geometries) {
    if (!g.shape.polytope) continue;
    vertices = std::max(vertices, g.shape.polytope->vertices.size());
    for (const detail::Polytope::Face& f : g.shape.polytope->faces) most = std::max(most, static_cast<std::size_t>(f.count));
  }
  patch_scratch.polygon.reserve(2 * most + 2);  // a convex polygon gains at most one corner from each side that cuts it
  patch_scratch.clipped.reserve(2 * most + 2);
  patch_scratch.corner_W.reserve(most);
  patch_scratch.vertex.reserve(std::max(most, vertices));
  for (auto* points : {&patch_scratch.gathered, &patch_scratch.kept}) points->reserve(2 * most + vertices + 4);
  patch_scratch.order.reserve(2 * most + vertices + 4);
}

Workspace::Workspace(const world::Model& model) : impl_(std::make_unique<Impl>(model)) {}
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;

}  // namespace stiction::contact
