#include "stiction/dynamics/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "stiction/dynamics/working_set.hpp"
#include "stiction/world/axis.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics::detail {
namespace {

using Eigen::Vector3d;
using world::Model;

/// Smallest part of the path that is halved further. The sweep may miss bodies that pass each other within such a part.
constexpr double kLeastPart = 1.0 / 256;

Sweep::Axis read_axis(const Model& model, const world::Body& body, std::size_t k) {
  const auto [dof, kind, ratio] = world::axis_at(model, body.axes[k]);
  const bool reaches = body.kind != world::BodyKind::Object && (k == 0 || world::axis_at(model, body.axes[k - 1]).dof != dof);
  return {0, body.axes[k], dof, ratio, kind == world::DofKind::Revolute, reaches};
}

/// Computes rotations and motion bounds of all bodies under δq.
void calc_motion(const Model& model, const StepWorkspace::Impl& work, const Eigen::VectorXd& delta, Sweep& sweep) {
  for (std::size_t i = 1; i < sweep.axes.size(); ++i) {
    const Sweep::Axis& axis = sweep.axes[i];
    const Sweep::Sums& before = sweep.sums[axis.before];
    sweep.sums[i].turned = before.turned + (axis.turns ? std::abs(axis.ratio * delta[axis.dof]) : 0.0);
    sweep.sums[i].moved = before.moved + (axis.reaches ? model.reach()[axis.dof - model.n_vu()] * std::abs(delta[axis.dof]) : 0.0);
  }
  for (std::size_t b = 0; b < sweep.last.size(); ++b) {
    const world::Body& body = model.bodies()[b];
    const Sweep::Sums& all = sweep.sums[sweep.last[b]];
    sweep.motion[b] = {all.turned, body.kind == world::BodyKind::Object ? object_travel(model, work, at(body.owner), delta) : all.moved};
  }
}

void calc_twists(const Eigen::VectorXd& delta, const Sweep& sweep, Sweep::Place& place) {
  place.twists.resize(sweep.axes.size());
  for (std::size_t i = 1; i < sweep.axes.size(); ++i) {
    const Sweep::Axis& axis = sweep.axes[i];
    Sweep::Twist& twist = place.twists[i];
    const Vector3d move = axis.ratio * delta[axis.dof] * place.kinematics.axis_W.col(axis.axis);
    twist = place.twists[axis.before];
    twist.v += axis.turns ? Vector3d(place.kinematics.origin_W.col(axis.axis).cross(move)) : move;
    if (axis.turns) twist.w += move;
  }
}

/// Sets the first place, q.
void start_at(const world::Kinematics& kinematics, const Eigen::VectorXd& delta, Sweep& sweep) {
  if (sweep.places.empty()) sweep.places.emplace_back();
  sweep.places.front().kinematics = kinematics;
  calc_twists(delta, sweep, sweep.places.front());
  sweep.n_places = 1;
}

/// The place q ⊕ s δq, computed once for all pairs.
const Sweep::Place& place_at(const Model& model, const StepInput& in, const Eigen::VectorXd& delta, double s, Sweep& sweep) {
  const auto end = sweep.places.begin() + static_cast<std::ptrdiff_t>(sweep.n_places);
  const auto known = std::find_if(sweep.places.begin(), end, [&](const Sweep::Place& place) { return place.s == s; });
  if (known != end) return *known;
  if (sweep.n_places == sweep.places.size()) sweep.places.emplace_back();
  Sweep::Place& place = sweep.places[sweep.n_places++];
  place.s = s;
  sweep.part = s * delta;
  world::retract(model, in.q, sweep.part, sweep.q);
  world::calc_kinematics(model, sweep.q, sweep.kinematics_work, place.kinematics);
  calc_twists(delta, sweep, place);
  return place;
}

/// Bound on the second-order motion over the whole path, ½ Θ Σ of (S.18): half of all turns times the motion by all joints.
double calc_second(const Sweep& sweep, std::size_t body, std::size_t shared) {
  return 0.5 * (sweep.motion[body].turned - sweep.sums[shared].turned) * (sweep.motion[body].moved - sweep.sums[shared].moved);
}

Vector3d calc_center(const Model& model, const world::Kinematics& kinematics, std::size_t geometry) {
  const world::Geometry& g = model.geometries()[geometry];
  return kinematics.X_WB[at(g.body)] * g.p_BCenter;
}

/// Computes the bounding spheres of all geometries and bounds on their motion.
void calc_balls(const Model& model, Sweep& sweep) {
  const Sweep::Place& start = sweep.places.front();
  for (std::size_t i = 0; i < sweep.balls.size(); ++i) {
    const world::Geometry& g = model.geometries()[i];
    const std::size_t body = at(g.body);
    const Sweep::Twist& twist = start.twists[sweep.last[body]];
    Sweep::Ball& ball = sweep.balls[i];
    ball.center = calc_center(model, start.kinematics, i);
    ball.v = twist.v + twist.w.cross(ball.center);
    ball.travel = sweep.motion[body].moved;
    if (model.bodies()[body].kind == world::BodyKind::Object || sweep.last[body] == 0) continue;
    const double turned = twist.w.norm(), first = ball.v.norm() + (turned > 0 ? turned * ball.radius : 0.0);
    ball.travel = std::min(ball.travel, first + calc_second(sweep, body, 0));
  }
}

/// r_a + r_b of (S.16). Joints that move both bodies do not change the distance between them and do not count.
double calc_travel(const Sweep::Pair& pair, const Sweep& sweep) {
  const double both = sweep.balls[pair.a].travel + sweep.balls[pair.b].travel;
  if (pair.shared == 0) return both;
  return std::min(both, sweep.motion[pair.body_a].moved + sweep.motion[pair.body_b].moved - 2 * sweep.sums[pair.shared].moved);
}

/// True if the bounding spheres do not meet. In the frame of the joints that move both, the centres pass each other on a straight line, up
/// to the second-order motion.
bool spheres_stay_apart(const Sweep::Pair& pair, const Sweep& sweep) {
  const Sweep::Ball &a = sweep.balls[pair.a], &b = sweep.balls[pair.b];
  const Vector3d apart = a.center - b.center;
  Vector3d move = a.v - b.v;
  if (pair.shared != 0) move -= sweep.places.front().twists[pair.shared].w.cross(apart);
  const double way2 = move.squaredNorm(), s = way2 > 0 ? std::clamp(-apart.dot(move) / way2, 0.0, 1.0) : 0.0;
  const double reach =
      pair.radii + pair.touching + calc_second(sweep, pair.body_a, pair.shared) + calc_second(sweep, pair.body_b, pair.shared);
  return (apart + s * move).squaredNorm() > reach * reach;
}

/// Lists the pairs whose bodies move farther than the distance within which contacts are known.
void list_far_travellers(double margin, Sweep& sweep) {
  sweep.far.clear();
  for (std::size_t i = 0; i < sweep.pairs.size(); ++i) {
    const Sweep::Pair& pair = sweep.pairs[i];
    const Sweep::Ball &a = sweep.balls[pair.a], &b = sweep.balls[pair.b];
    const double both = a.travel + b.travel, reach = pair.radii + pair.touching + both;
    if (both <= pair.seen + margin || (a.center - b.center).squaredNorm() > reach * reach) continue;  // most pairs end here
    if (calc_travel(pair, sweep) <= pair.seen + margin || spheres_stay_apart(pair, sweep)) continue;
    if (!std::ranges::binary_search(sweep.met, static_cast<int>(i))) sweep.far.push_back(static_cast<int>(i));
  }
}

/// A pair and the motion that is checked.
struct Way {
  const Model& model;
  const StepInput& in;
  const Eigen::VectorXd& delta;
  int index;
  const Sweep::Pair& pair;
  Sweep& sweep;
};

/// Nearest points of the pair at s.
struct Stop {
  double s;
  contact::Distance nearest;
};

Stop stop_at(const Way& way, double s) {
  const Sweep::Place& place = place_at(way.model, way.in, way.delta, s, way.sweep);
  return {s, contact::pair_distance(way.model, place.kinematics, way.index, way.sweep.contact_work)};
}

/// Bound (S.18) on how far the two bodies approach each other between a stop and s, along the line of their nearest points [m]. s may lie
/// before or after the stop.
double calc_closing(const Way& way, const Stop& from, double s) {
  const Sweep::Place& place = place_at(way.model, way.in, way.delta, from.s, way.sweep);
  const double share = std::abs(s - from.s);
  const Vector3d n = s > from.s ? from.nearest.nhat_BA_W : Vector3d(-from.nearest.nhat_BA_W);
  const auto closing = [&](std::size_t geometry, std::size_t body, const Vector3d& towards) {
    const std::size_t last = way.sweep.last[body], shared = way.pair.shared;
    if (last == shared) return 0.0;
    const Vector3d w = place.twists[last].w - place.twists[shared].w;
    const Vector3d v = place.twists[last].v - place.twists[shared].v + w.cross(calc_center(way.model, place.kinematics, geometry));
    const double turned = towards.cross(w).norm();
    const double first = towards.dot(v) + (turned > 0 ? turned * way.sweep.balls[geometry].radius : 0.0);
    return share *
           std::min(way.sweep.motion[body].moved - way.sweep.sums[shared].moved, first + share * calc_second(way.sweep, body, shared));
  };
  return closing(way.pair.a, way.pair.body_a, -n) + closing(way.pair.b, way.pair.body_b, n);
}

/// True if the pair does not meet between a and s, by conservative advancement from both ends (S.24). If no separating plane holds over the
/// whole part, the part is halved.
/// @param known  the stop at s if it is known, or null
bool stays_apart(const Way& way, const Stop& a, double s, const Stop* known = nullptr) {
  const double forwards = calc_closing(way, a, s), room_a = a.nearest.phi - way.pair.touching;
  if (room_a > forwards) return true;
  const Stop b = known ? *known : stop_at(way, s);
  const double room_b = b.nearest.phi - way.pair.touching;
  if (room_b < 0) return false;
  const double backwards = calc_closing(way, b, a.s);
  if (room_b > backwards || room_a / forwards + room_b / backwards > 1 || s - a.s <= kLeastPart) return true;
  const Stop between = stop_at(way, 0.5 * (a.s + s));
  return stays_apart(way, a, between.s, &between) && stays_apart(way, between, s, &b);
}

}  // namespace

Sweep::Sweep(const Model& model)
    : axes(1),
      last(model.bodies().size(), 0),
      motion(model.bodies().size()),
      balls(model.geometries().size()),
      kinematics_work(model),
      contact_work(model),
      q(model.n_q()) {
  std::vector<std::size_t> of_axis(at(model.n_v()) + model.followers().size(), 0);
  for (std::size_t b = 0; b < last.size(); ++b) {
    const world::Body& body = model.bodies()[b];
    for (std::size_t k = 0; k < body.axes.size(); ++k) {
      std::size_t& index = of_axis[at(body.axes[k])];
      if (index == 0) {
        index = axes.size();
        axes.push_back(read_axis(model, body, k));
        axes.back().before = last[b];
      }
      last[b] = index;
    }
  }
  sums.resize(axes.size());
  for (std::size_t i = 0; i < balls.size(); ++i) balls[i].radius = model.geometries()[i].bounding_radius;
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    const world::Pair& p = model.pairs()[at(i)];
    Pair pair{.a = at(p.geometry_a), .b = at(p.geometry_b)};
    pair.body_a = at(model.geometries()[pair.a].body), pair.body_b = at(model.geometries()[pair.b].body);
    const std::vector<int>&axes_a = model.bodies()[pair.body_a].axes, &axes_b = model.bodies()[pair.body_b].axes;
    const auto end = std::ranges::mismatch(axes_a, axes_b).in1;
    if (end != axes_a.begin()) pair.shared = of_axis[at(*std::prev(end))];
    pair.radii = balls[pair.a].radius + balls[pair.b].radius;
    pair.touching = world::share::kMotionless * model.scales().pair(i).length;
    pair.seen = std::max(model.scene().contact_distance, p.max_distance);
    pairs.push_back(pair);
  }
}

bool add_met(const Model& model, const StepInput& in, double margin, StepWorkspace::Impl& work) {
  const Eigen::VectorXd& delta = work.solution.x;
  const double motion = 2 * motion_bound(model, work, delta);
  if (!(motion > model.scene().contact_distance + margin)) return false;
  if (!work.sweep) work.sweep.emplace(model);
  Sweep& sweep = *work.sweep;
  if (work.contacts.size() == work.near_contacts) sweep.met.clear();
  start_at(work.kinematics, delta, sweep);
  calc_motion(model, work, delta, sweep);
  calc_balls(model, sweep);
  list_far_travellers(margin, sweep);

  sweep.added.clear();
  for (const int i : sweep.far) {
    const Way way{model, in, delta, i, sweep.pairs[at(i)], sweep};
    const Stop stop = stop_at(way, 0);
    if (stop.nearest.phi < way.pair.seen + margin || stop.nearest.phi > calc_travel(way.pair, sweep)) continue;
    if (!stays_apart(way, stop, 1)) sweep.added.push_back(i);
  }
  if (sweep.added.empty()) return false;
  contact::query_pairs(model, work.kinematics, sweep.added, motion, work.contact_work, sweep.contacts);
  contact::split_turning(model, sweep.contacts);
  for (const contact::Contact& contact : sweep.contacts) {
    work.contacts.push_back(contact);
    if (in.friction) work.contacts.back().friction *= (*in.friction)[contact.pair];
  }
  for (const int pair : sweep.added) sweep.met.insert(std::ranges::lower_bound(sweep.met, pair), pair);
  contact::calc_jacobians(model, work.kinematics, work.contacts, work.contact_work, work.J);
  work.margin_seen = -1;  // no other step may reuse these contacts
  return true;
}

}  // namespace stiction::dynamics::detail
