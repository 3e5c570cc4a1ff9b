#include "stiction/planning/force_gap.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

double largest_gap(const world::Model& model, std::span<const dynamics::ContactImpulse> contacts, const Eigen::VectorXd& q_next, bool far,
                   GeometryWorkspace& work) {
  constexpr double kSmall = 0.4, kLongSlip = 3;
  double worst = 0;
  bool placed = false;
  for (const auto& c : contacts) {
    if (!c.active) continue;
    const double tolerance = model.scales().contact_tolerance(c.contact.pair);
    double gap = c.anitescu_gap();
    if (gap > kSmall * tolerance || far || c.slide() > kLongSlip * tolerance) {
      if (!placed) world::calc_kinematics(model, q_next, work.kinematics_work, work.kinematics);
      placed = true;
      gap = contact::pair_distance(model, work.kinematics, c.contact.pair, work.contact_work).phi;
    }
    worst = std::max(worst, gap / tolerance);
  }
  return worst;
}

}  // namespace

double calc_force_gap(const world::Model& model, const dynamics::StepResult& step, GeometryWorkspace& work) {
  constexpr double kLongTurn = 0.02, kLongWay = 0.2;  // of a step [rad], [L]
  bool far = false;
  for (int o = 0; o < static_cast<int>(model.objects().size()); ++o) {
    const auto& object = model.objects()[static_cast<std::size_t>(o)];
    for (int v = object.v_begin; v < object.v_begin + object.n_v; ++v) {
      const bool turns = model.dofs()[static_cast<std::size_t>(v)].kind == world::DofKind::Revolute;
      far = far || std::abs(step.delta[v]) > (turns ? kLongTurn : kLongWay * model.scales().object(o).length);
    }
  }
  return largest_gap(model, step.contacts, step.q_next, far, work);
}

double calc_force_gap(const world::Model& model, const dynamics::Knot& knot, GeometryWorkspace& work) {
  return largest_gap(model, knot.contacts, knot.q, false, work);
}

double calc_penetration(const world::Model& model, const dynamics::StepResult& step) {
  double share = 0;
  for (const auto& c : step.contacts) share = std::max(share, -c.contact.phi / model.scales().contact_tolerance(c.contact.pair));
  return share;
}

double calc_penetration(const world::Model& model, const Eigen::VectorXd& q, GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  contact::query(model, work.kinematics, {}, work.contact_work, work.contacts);
  double share = 0;
  for (const auto& c : work.contacts) share = std::max(share, -c.phi / model.scales().contact_tolerance(c.pair));
  return share;
}

}  // namespace stiction::planning
