#include "stiction/dynamics/sweep.hpp"

#include <algorithm>
#include <limits>

#include "stiction/dynamics/working_set.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics::detail {
namespace {

using world::Model;

/// A sweep advances by at least this share of its way: where two bodies pass each other nearer than that, it is this coarse.
constexpr double kLeastAdvance = 1.0 / 256;

/// Farthest that a point of a robot's geometry travels under δq [m]: v + ω × r of its bounding sphere to first order, and what turning axes add to second.
double calc_link_travel(const Model& model, const world::Kinematics& kinematics, const world::Geometry& geometry,
                        const Eigen::VectorXd& delta, const std::vector<double>& joint_travel) {
  const world::Body& body = model.bodies()[at(geometry.body)];
  const Eigen::Vector3d center = kinematics.X_WB[at(geometry.body)] * geometry.p_BCenter;
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();
  for (const int axis : body.axes) {
    const world::Follower* follower = axis < model.n_v() ? nullptr : &model.followers()[at(axis - model.n_v())];
    const world::Dof& dof = model.dofs()[at(follower ? follower->dof : axis)];
    const Eigen::Vector3d move = (follower ? follower->ratio * delta[follower->dof] : delta[axis]) * kinematics.axis_W.col(axis);
    if ((follower ? follower->kind : dof.kind) == world::DofKind::Prismatic) {
      v += move;
    } else {
      v += move.cross(center - kinematics.origin_W.col(axis));
      w += move;
    }
  }
  double turn = 0, sum = 0;
  for (const int dof : body.dofs) {
    if (model.dofs()[at(dof)].kind == world::DofKind::Revolute) turn += std::abs(delta[dof]);
    sum += joint_travel[at(dof - model.n_vu())];
  }
  return std::min(sum, v.norm() + w.norm() * geometry.bounding_radius + 0.5 * turn * sum);
}

void calc_travels(const Model& model, const StepWorkspace::Impl& work, const Eigen::VectorXd& delta, Sweep& sweep) {
  sweep.joint_travel.resize(at(model.n_a()));
  for (int j = 0; j < model.n_a(); ++j) sweep.joint_travel[at(j)] = model.reach()[j] * std::abs(delta[model.n_vu() + j]);
  sweep.travel.clear();
  for (const world::Geometry& geometry : model.geometries()) {
    const world::Body& body = model.bodies()[at(geometry.body)];
    const bool object = body.kind == world::BodyKind::Object;
    sweep.travel.push_back(object              ? object_travel(model, work, at(body.owner), delta)
                           : body.dofs.empty() ? 0.0
                                               : calc_link_travel(model, work.kinematics, geometry, delta, sweep.joint_travel));
  }
}

/// Pairs whose sides travel farther than contacts are looked for.
void list_far_travellers(const Model& model, double margin, Sweep& sweep) {
  sweep.pairs.clear();
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    if (sweep.travel_of(model, i) > sweep.seen(model, i, margin) && !std::ranges::binary_search(sweep.met, i)) sweep.pairs.push_back(i);
  }
}

/// Conservative advancement: no point of the pair comes nearer by more than its travel, so that nothing is met within φ/travel.
bool meets(const Model& model, const StepInput& in, int pair, double phi, const Eigen::VectorXd& delta, Sweep& sweep) {
  const double travel = sweep.travel_of(model, pair), touching = world::share::kMotionless * model.scales().pair(pair).length;
  for (double s = 0;;) {
    s += std::max(phi / travel, kLeastAdvance);
    const bool end = s >= 1;
    sweep.part = std::min(s, 1.0) * delta;
    world::retract(model, in.q, sweep.part, sweep.q);
    world::calc_kinematics(model, sweep.q, sweep.kinematics_work, sweep.kinematics);
    phi = contact::pair_distance(model, sweep.kinematics, pair, sweep.contact_work).phi;
    if (phi < touching) return true;
    if (end) return false;
  }
}

}  // namespace

Sweep::Sweep(const Model& model) : kinematics_work(model), contact_work(model), q(model.n_q()) {}

double Sweep::travel_of(const Model& model, int pair) const {
  const world::Pair& p = model.pairs()[at(pair)];
  const double both = travel[at(p.geometry_a)] + travel[at(p.geometry_b)];
  const world::Body &a = model.bodies()[at(model.geometries()[at(p.geometry_a)].body)],
                    &b = model.bodies()[at(model.geometries()[at(p.geometry_b)].body)];
  if (a.kind != world::BodyKind::Robot || b.kind != world::BodyKind::Robot || a.owner != b.owner) return both;
  double apart = 0;  // joints that move both keep them as far from each other as they are
  for (const auto* side : {&a, &b}) {
    const auto& other = side == &a ? b.dofs : a.dofs;
    for (const int dof : side->dofs) {
      if (!std::ranges::binary_search(other, dof)) apart += joint_travel[at(dof - model.n_vu())];
    }
  }
  return std::min(apart, both);
}

double Sweep::seen(const Model& model, int pair, double margin) const {
  return std::max(model.scene().contact_distance, model.pairs()[at(pair)].max_distance) + margin;
}

bool add_met(const Model& model, const StepInput& in, double margin, StepWorkspace::Impl& work) {
  const Eigen::VectorXd& delta = work.solution.x;
  const double motion = 2 * motion_bound(model, work, delta);
  if (!(motion > model.scene().contact_distance + margin)) return false;
  if (!work.sweep) work.sweep.emplace(model);
  Sweep& sweep = *work.sweep;
  if (work.contacts.size() == work.near_contacts) sweep.met.clear();
  calc_travels(model, work, delta, sweep);
  list_far_travellers(model, margin, sweep);
  if (sweep.pairs.empty()) return false;
  contact::query_pairs(model, work.kinematics, sweep.pairs, motion, work.contact_work, sweep.contacts);

  const std::size_t before = work.contacts.size();
  for (std::size_t i = 0, end = 0; i < sweep.contacts.size(); i = end) {
    const int pair = sweep.contacts[i].pair;
    double phi = std::numeric_limits<double>::infinity();
    for (end = i; end < sweep.contacts.size() && sweep.contacts[end].pair == pair; ++end) phi = std::min(phi, sweep.contacts[end].phi);
    if (phi < sweep.seen(model, pair, margin) || phi > sweep.travel_of(model, pair) || !meets(model, in, pair, phi, delta, sweep)) continue;
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
