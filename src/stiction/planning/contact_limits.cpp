#include "stiction/planning/contact_limits.hpp"

#include <algorithm>
#include <span>

#include "stiction/world/scales.hpp"

namespace stiction::planning {

double calc_force_gap(const world::Model& model, const Eigen::VectorXd& q_next, std::span<const dynamics::ContactImpulse> contacts,
                      contact::GeometryWorkspace& work) {
  double worst = 0;
  int pair = -1;  // pair of the contact before: contacts of a pair follow each other
  for (const auto& c : contacts) {
    if (!c.active || c.contact.pair == pair) continue;
    if (pair < 0) world::calc_kinematics(model, q_next, work.kinematics_work, work.kinematics);
    pair = c.contact.pair;
    const double gap = contact::pair_distance(model, work.kinematics, pair, work.contact_work).phi;
    worst = std::max(worst, gap / model.scales().contact_tolerance(pair));
  }
  return worst;
}

double calc_penetration(const world::Model& model, const dynamics::StepResult& step) {
  double share = 0;
  for (const auto& c : step.contacts) share = std::max(share, -c.contact.phi / model.scales().contact_tolerance(c.contact.pair));
  return share;
}

double calc_penetration(const world::Model& model, const Eigen::VectorXd& q, contact::GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  contact::query(model, work.kinematics, {}, work.contact_work, work.contacts);
  double share = 0;
  for (const auto& c : work.contacts) share = std::max(share, -c.phi / model.scales().contact_tolerance(c.pair));
  return share;
}

}  // namespace stiction::planning
