#include "stiction/planning/force_gap.hpp"

#include <algorithm>
#include <span>

namespace stiction::planning {
namespace {

double largest_gap(const world::Model& model, std::span<const dynamics::ContactImpulse> contacts, const Eigen::VectorXd& q_next, bool far,
                   GeometryWorkspace& work) {
  constexpr double kSmall = 0.4e-3, kLongSlip = 3e-3;  // [m]
  double worst = 0;
  bool placed = false;
  for (const auto& c : contacts) {
    if (!c.active) continue;
    double gap = c.anitescu_gap();
    if (gap > kSmall || far || c.slide() > kLongSlip) {
      if (!placed) world::calc_kinematics(model, q_next, work.kinematics_work, work.kinematics);
      placed = true;
      gap = contact::pair_distance(model, work.kinematics, c.contact.pair, work.contact_work).phi;
    }
    worst = std::max(worst, gap);
  }
  return worst;
}

}  // namespace

double calc_force_gap(const world::Model& model, const dynamics::StepResult& step, GeometryWorkspace& work) {
  constexpr double kLong = 0.02;  // of a step [m or rad]
  return largest_gap(model, step.contacts, step.q_next, step.delta.head(model.n_vu()).lpNorm<Eigen::Infinity>() > kLong, work);
}

double calc_force_gap(const world::Model& model, const dynamics::Knot& knot, GeometryWorkspace& work) {
  return largest_gap(model, knot.contacts, knot.q, false, work);
}

double calc_penetration(const dynamics::StepResult& step) {
  double depth = 0;
  for (const auto& c : step.contacts) depth = std::max(depth, -c.contact.phi);
  return depth;
}

double calc_penetration(const world::Model& model, const Eigen::VectorXd& q, GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  contact::query(model, work.kinematics, {}, work.contact_work, work.contacts);
  double depth = 0;
  for (const auto& c : work.contacts) depth = std::max(depth, -c.phi);
  return depth;
}

}  // namespace stiction::planning
