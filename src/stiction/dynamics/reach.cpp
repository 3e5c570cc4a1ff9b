#include "stiction/dynamics/reach.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "stiction/dynamics/working_set.hpp"
#include "stiction/world/axis.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics::detail {
namespace {

using world::Model;

/// Distance added to the commanded motion, because pushed objects turn. Must not be below the distances of include_within_reach().
constexpr double kNear = 0.05;  // share of L of the pair (world::Scales)

/// Computes the first-order twists of all bodies under δq at the origin of W. Rows use the same first-order motion.
void calc_twists(const Model& model, const world::Kinematics& kinematics, const Eigen::VectorXd& delta, Reach& reach) {
  for (std::size_t b = 0; b < model.bodies().size(); ++b) {
    Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = v;
    for (const int axis : model.bodies()[b].axes) {
      const auto [dof, kind, ratio] = world::axis_at(model, axis);
      const bool turns = kind == world::DofKind::Revolute;
      const Eigen::Vector3d move = ratio * delta[dof] * kinematics.axis_W.col(axis);
      v += turns ? kinematics.origin_W.col(axis).cross(move) : move;
      if (turns) w += move;
    }
    reach.v[b] = v, reach.w[b] = w;
  }
}

/// Bound on ‖J_c δq‖ for every contact of a pair with distance φ: travel + turn φ.
struct Travel {
  double travel, turn;  ///< [m], [rad]
};

/// Motion of the geometry with the smaller bounding sphere in the frame of the other geometry, and the rotation of that other geometry,
/// which turns the segment of length φ between the witness points.
Travel calc_travel(const Model& model, int pair, const Reach& reach) {
  const world::Pair& p = model.pairs()[at(pair)];
  const world::Geometry *small = &model.geometries()[at(p.geometry_a)], *other = &model.geometries()[at(p.geometry_b)];
  int g = p.geometry_a;
  if (small->bounding_radius > other->bounding_radius) std::swap(small, other), g = p.geometry_b;
  const std::size_t a = at(small->body), b = at(other->body);
  const Eigen::Vector3d w = reach.w[a] - reach.w[b];
  const Eigen::Vector3d v = reach.v[a] - reach.v[b] + w.cross(reach.center[at(g)]);
  return {v.norm() + w.norm() * small->bounding_radius, reach.w[b].norm()};
}

double friction_of(const Model& model, int pair, const StepInput& in, const StepOptions& options) {
  return model.pairs()[at(pair)].friction * options.friction_scale * (in.friction ? (*in.friction)[pair] : 1.0);
}

template <class S>
bool either(const world::Shape& a, const world::Shape& b) {
  return std::holds_alternative<S>(a) || std::holds_alternative<S>(b);
}

/// True for meshes and for flat faces other than against spheres. For round shapes the distance costs no more than a bound on it.
bool is_costly(const world::Shape& a, const world::Shape& b) {
  const bool flat = either<world::Box>(a, b) || either<world::Cylinder>(a, b);
  return either<world::Mesh>(a, b) || (flat && !either<world::Sphere>(a, b));
}

}  // namespace

Reach::Reach(const Model& model)
    : near(model.pairs().size(), std::numeric_limits<double>::infinity()),
      v(model.bodies().size()),
      w(v.size()),
      center(model.geometries().size()) {
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    const world::Pair& p = model.pairs()[at(i)];
    if (is_costly(model.geometries()[at(p.geometry_a)].shape, model.geometries()[at(p.geometry_b)].shape)) pairs.push_back(i);
  }
  if (pairs.size() < v.size()) pairs.clear();  // the twists of all bodies would cost more
  close.reserve(pairs.size());
}

void guess_reach(const Model& model, const StepInput& in, const StepOptions& options, double margin, StepWorkspace::Impl& work) {
  Reach& reach = work.reach;
  for (std::size_t g = 0; g < reach.center.size(); ++g)
    reach.center[g] = work.kinematics.X_WB[at(model.geometries()[g].body)] * model.geometries()[g].p_BCenter;
  reach.margin = margin;
  calc_twists(model, work.kinematics, work.commanded, reach);
  double farthest = 0;  // largest commanded motion of a link's surface, which bounds the motion of pushed objects
  for (std::size_t g = 0; g < reach.center.size(); ++g) {
    const world::Geometry& geometry = model.geometries()[g];
    const std::size_t b = at(geometry.body);
    if (model.bodies()[b].kind != world::BodyKind::Robot) continue;
    const double travel = (reach.v[b] + reach.w[b].cross(reach.center[g])).norm() + reach.w[b].norm() * geometry.bounding_radius;
    farthest = std::max(farthest, travel);
  }
  reach.close.clear();
  for (const int i : reach.pairs) {
    const world::Pair& p = model.pairs()[at(i)];
    const double radii = model.geometries()[at(p.geometry_a)].bounding_radius + model.geometries()[at(p.geometry_b)].bounding_radius;
    const double most = radii + p.max_distance + margin;
    if ((reach.center[at(p.geometry_a)] - reach.center[at(p.geometry_b)]).squaredNorm() > most * most) continue;
    reach.close.push_back(i);
    const bool object = model.bodies()[at(model.geometries()[at(p.geometry_a)].body)].kind ==
                        world::BodyKind::Object;  // if the pair has an object, it comes first
    const double travel = calc_travel(model, i, reach).travel + (object ? farthest : 0.0);
    const double mu = friction_of(model, i, in, options);
    const double seen = p.max_distance + margin;
    reach.near[at(i)] = std::min(seen, kNear * model.scales().pair(i).length + (1 + mu) * travel);
  }
}

bool stays_within_reach(const Model& model, const StepInput& in, const StepOptions& options, StepWorkspace::Impl& work) {
  Reach& reach = work.reach;
  calc_twists(model, work.kinematics, work.solution.x, reach);
  for (const int i : reach.close) {
    if (reach.near[at(i)] >= model.pairs()[at(i)].max_distance + reach.margin) continue;
    const Travel most = calc_travel(model, i, reach);
    const double mu = friction_of(model, i, in, options);
    if ((1 + mu) * (most.travel + most.turn * reach.near[at(i)]) > reach.near[at(i)] || (1 + mu) * most.turn >= 1) return false;
  }
  return true;
}

}  // namespace stiction::dynamics::detail
