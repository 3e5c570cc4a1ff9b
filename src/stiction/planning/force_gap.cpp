#include "stiction/planning/force_gap.hpp"

#include <algorithm>

namespace stiction::planning {

double calc_force_gap(const world::Model& model, const dynamics::StepResult& step, GeometryWorkspace& work) {
  constexpr double kSmall = 0.4e-3, kLong = 0.02;  // [m]; of a step [m or rad]
  const bool far = step.delta.head(model.n_vu()).lpNorm<Eigen::Infinity>() > kLong;
  double worst = 0;
  bool placed = false;
  for (const auto& c : step.contacts) {
    if (!c.active) continue;
    double gap = c.anitescu_gap();
    if (gap > kSmall || far) {
      if (!placed) world::calc_kinematics(model, step.q_next, work.kinematics_work, work.kinematics);
      placed = true;
      gap = contact::pair_distance(model, work.kinematics, c.contact.pair, work.contact_work).phi;
    }
    worst = std::max(worst, gap);
  }
  return worst;
}

double calc_penetration(const dynamics::StepResult& step) {
  double depth = 0;
  for (const auto& c : step.contacts) depth = std::max(depth, -c.contact.phi);
  return depth;
}

}  // namespace stiction::planning
