#include "stiction/dynamics/sweep.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "stiction/dynamics/working_set.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics::detail {
namespace {

using world::Model;

/// A sweep advances by at least this share of its way: where two bodies pass each other nearer than that, it is this coarse.
constexpr double kLeastAdvance = 1.0 / 256;

/// A joint as it moves a body: the coordinate behind it, and how far it goes for one of that, 1 except for joints that follow another.
struct Joint {
  int dof;
  double ratio;
  bool turns;
};

Joint joint_of(const Model& model, int axis) {
  if (axis < model.n_v()) return {axis, 1, model.dofs()[at(axis)].kind == world::DofKind::Revolute};
  const world::Follower& follower = model.followers()[at(axis - model.n_v())];
  return {follower.dof, follower.ratio, follower.kind == world::DofKind::Revolute};
}

const world::Body& body_of(const Model& model, int geometry) { return model.bodies()[at(model.geometries()[at(geometry)].body)]; }

/// Twist of a geometry under the rest of δq, by the joints after the first `shared` of them: of the centre of its bounding sphere.
struct Twist {
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();
};

Twist calc_twist(const Model& model, const world::Kinematics& kinematics, int geometry, std::size_t shared, const Eigen::VectorXd& delta) {
  const world::Body& body = body_of(model, geometry);
  const Eigen::Vector3d center = kinematics.X_WB[at(model.geometries()[at(geometry)].body)] * model.geometries()[at(geometry)].p_BCenter;
  Twist out;
  for (std::size_t k = shared; k < body.axes.size(); ++k) {
    const Joint joint = joint_of(model, body.axes[k]);
    const Eigen::Vector3d move = joint.ratio * delta[joint.dof] * kinematics.axis_W.col(body.axes[k]);
    out.v += joint.turns ? move.cross(center - kinematics.origin_W.col(body.axes[k])) : move;
    if (joint.turns) out.w += move;
  }
  return out;
}

/// Bound of what a turning twist leaves out: half the product of all turns with what all joints move.
double calc_second(const Sweep::Motion& motion, std::size_t shared, std::size_t joints) {
  return 0.5 * (motion.turned[joints] - motion.turned[shared]) * (motion.moved[joints] - motion.moved[shared]);
}

void calc_motion(const Model& model, const StepWorkspace::Impl& work, int geometry, const Eigen::VectorXd& delta, Sweep::Motion& out) {
  const world::Geometry& g = model.geometries()[at(geometry)];
  const world::Body& body = body_of(model, geometry);
  const bool object = body.kind == world::BodyKind::Object;
  out.center = work.kinematics.X_WB[at(g.body)] * g.p_BCenter;
  out.turned.assign(1, 0.0);
  out.moved.assign(1, 0.0);
  int last = -1;
  for (const int axis : body.axes) {
    const Joint joint = joint_of(model, axis);
    const double angle = std::abs(joint.ratio * delta[joint.dof]);
    const bool counted = object || joint.dof == last;  // reach is that of a coordinate and of what follows it
    out.turned.push_back(out.turned.back() + (joint.turns ? angle : 0.0));
    out.moved.push_back(out.moved.back() + (counted ? 0.0 : model.reach()[joint.dof - model.n_vu()] * std::abs(delta[joint.dof])));
    last = joint.dof;
  }
  if (object) out.moved.back() = object_travel(model, work, at(body.owner), delta);
  const Twist twist = calc_twist(model, work.kinematics, geometry, 0, delta);
  out.v = twist.v;
  const double turned = twist.w.norm(), first = twist.v.norm() + (turned > 0 ? turned * g.bounding_radius : 0.0);
  out.travel = object ? out.moved.back() : std::min(out.moved.back(), first + calc_second(out, 0, body.axes.size()));
}

/// (S.16), r_a + r_b. Joints that move both keep them as far from each other as they are.
double calc_travel(const Model& model, int pair, const Sweep& sweep) {
  const world::Pair& p = model.pairs()[at(pair)];
  const Sweep::Motion &a = sweep.motion[at(p.geometry_a)], &b = sweep.motion[at(p.geometry_b)];
  const std::size_t shared = sweep.shared[at(pair)];
  const double both = a.travel + b.travel;
  return shared == 0 ? both : std::min(both, a.moved.back() - a.moved[shared] + b.moved.back() - b.moved[shared]);
}

/// Distance within which the contacts of a pair are known [m].
double calc_seen(const Model& model, int pair, double margin) {
  return std::max(model.scene().contact_distance, model.pairs()[at(pair)].max_distance) + margin;
}

/// The bounding spheres do not come together: their centres approach along the line between them, which what moves both does not change.
bool spheres_stay_apart(const Model& model, int pair, double touching, const Sweep& sweep) {
  const world::Pair& p = model.pairs()[at(pair)];
  const Sweep::Motion &a = sweep.motion[at(p.geometry_a)], &b = sweep.motion[at(p.geometry_b)];
  const Eigen::Vector3d apart = a.center - b.center;
  const double distance = apart.norm(),
               radii = model.geometries()[at(p.geometry_a)].bounding_radius + model.geometries()[at(p.geometry_b)].bounding_radius;
  if (!(distance > radii)) return false;
  const std::size_t shared = sweep.shared[at(pair)];
  const double closing = apart.dot(b.v - a.v) / distance + calc_second(a, shared, sweep.joints[at(pair)][0]) +
                         calc_second(b, shared, sweep.joints[at(pair)][1]);
  return distance - radii - closing > touching;
}

double calc_touching(const Model& model, int pair) { return world::share::kMotionless * model.scales().pair(pair).length; }

/// Pairs whose sides travel farther than contacts are looked for.
void list_far_travellers(const Model& model, double margin, Sweep& sweep) {
  sweep.pairs.clear();
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    if (calc_travel(model, i, sweep) <= calc_seen(model, i, margin)) continue;
    if (spheres_stay_apart(model, i, calc_touching(model, i), sweep) || std::ranges::binary_search(sweep.met, i)) continue;
    sweep.pairs.push_back(i);
  }
}

/// (S.18): how far the two come towards each other on the rest of the way, along the line of their nearest points [m].
double calc_closing(const Model& model, const world::Kinematics& kinematics, int pair, const Eigen::Vector3d& nhat_BA_W,
                    const Eigen::VectorXd& delta, double rest, const Sweep& sweep) {
  const world::Pair& p = model.pairs()[at(pair)];
  const std::size_t shared = sweep.shared[at(pair)];
  double out = 0;
  for (const int side : {0, 1}) {
    const int geometry = side == 0 ? p.geometry_a : p.geometry_b;
    const Eigen::Vector3d n = side == 0 ? Eigen::Vector3d(-nhat_BA_W) : nhat_BA_W;
    const Sweep::Motion& motion = sweep.motion[at(geometry)];
    const Twist twist = calc_twist(model, kinematics, geometry, shared, delta);
    const double turned = n.cross(twist.w).norm();
    const double first = n.dot(twist.v) + (turned > 0 ? turned * model.geometries()[at(geometry)].bounding_radius : 0.0);
    out += rest * std::min(motion.moved.back() - motion.moved[shared],
                           first + rest * calc_second(motion, shared, sweep.joints[at(pair)][at(side)]));
  }
  return out;
}

/// Conservative advancement: where the plane between the two stays between them to the end, nothing is met; nor before the share φ/closing of the rest.
bool meets(const Model& model, const StepInput& in, int pair, const Eigen::VectorXd& delta, StepWorkspace::Impl& work, Sweep& sweep) {
  const double touching = calc_touching(model, pair);
  contact::Distance nearest = contact::pair_distance(model, work.kinematics, pair, work.contact_work);
  double closing = calc_closing(model, work.kinematics, pair, nearest.nhat_BA_W, delta, 1, sweep);
  for (double s = 0; s < 1 && nearest.phi - closing <= touching;) {
    s = std::min(1.0, s + std::max((1 - s) * nearest.phi / closing, kLeastAdvance));
    sweep.part = s * delta;
    world::retract(model, in.q, sweep.part, sweep.q);
    world::calc_kinematics(model, sweep.q, sweep.kinematics_work, sweep.kinematics);
    nearest = contact::pair_distance(model, sweep.kinematics, pair, sweep.contact_work);
    if (nearest.phi < touching) return true;
    closing = calc_closing(model, sweep.kinematics, pair, nearest.nhat_BA_W, delta, 1 - s, sweep);
  }
  return false;
}

}  // namespace

Sweep::Sweep(const Model& model) : kinematics_work(model), contact_work(model), q(model.n_q()), motion(model.geometries().size()) {
  for (const world::Pair& p : model.pairs()) {
    const std::vector<int>&a = body_of(model, p.geometry_a).axes, &b = body_of(model, p.geometry_b).axes;
    joints.push_back({a.size(), b.size()});
    shared.push_back(at(static_cast<int>(std::ranges::mismatch(a, b).in1 - a.begin())));
  }
}

bool add_met(const Model& model, const StepInput& in, double margin, StepWorkspace::Impl& work) {
  const Eigen::VectorXd& delta = work.solution.x;
  const double motion = 2 * motion_bound(model, work, delta);
  if (!(motion > model.scene().contact_distance + margin)) return false;
  if (!work.sweep) work.sweep.emplace(model);
  Sweep& sweep = *work.sweep;
  if (work.contacts.size() == work.near_contacts) sweep.met.clear();
  for (int i = 0; i < static_cast<int>(model.geometries().size()); ++i) calc_motion(model, work, i, delta, sweep.motion[at(i)]);
  list_far_travellers(model, margin, sweep);
  if (sweep.pairs.empty()) return false;
  contact::query_pairs(model, work.kinematics, sweep.pairs, motion, work.contact_work, sweep.contacts);

  const std::size_t before = work.contacts.size();
  for (std::size_t i = 0, end = 0; i < sweep.contacts.size(); i = end) {
    const int pair = sweep.contacts[i].pair;
    double phi = std::numeric_limits<double>::infinity();
    for (end = i; end < sweep.contacts.size() && sweep.contacts[end].pair == pair; ++end) phi = std::min(phi, sweep.contacts[end].phi);
    if (phi < calc_seen(model, pair, margin) || phi > calc_travel(model, pair, sweep) || !meets(model, in, pair, delta, work, sweep))
      continue;
    for (std::size_t k = i; k < end; ++k) {
      work.contacts.push_back(sweep.contacts[k]);
      if (in.friction) work.contacts.back().friction *= (*in.friction)[pair];
    }
    sweep.met.insert(std::ranges::lower_bound(sweep.met, pair), pair);
  }
  if (work.contacts.size() == before) return false;
  contact::calc_jacobians(model, work.kinematics, work.contacts, work.contact_work, work.J);
  work.margin_seen = -1;  // no other step takes these over
  return true;
}

}  // namespace stiction::dynamics::detail
