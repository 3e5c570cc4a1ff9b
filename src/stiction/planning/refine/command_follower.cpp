#include "stiction/planning/refine/command_follower.hpp"

#include <algorithm>
#include <iterator>

#include "stiction/planning/contact_limits.hpp"

namespace stiction::planning::refinement {

Eigen::VectorXd CommandFollower::within_limits(const Eigen::VectorXd& command) const {
  return command.cwiseMax(problem_.model.lower()).cwiseMin(problem_.model.upper());
}

bool CommandFollower::step_within_efforts(Eigen::VectorXd& command) {
  int steps = 0;
  const core::Status status =
      dynamics::step_within_efforts(problem_.model, q, command, sizes_.exact, scratch_.steps, scratch_.step_result, steps);
  return work.add(steps, status);
}

bool CommandFollower::advance(const Eigen::VectorXd& command, Segment& segment) {
  const Eigen::VectorXd wanted = within_limits(command);  // rounding
  Eigen::VectorXd u_next = wanted;
  if (stop() || !step_within_efforts(u_next)) return false;
  const bool recoils = u_next != wanted && dynamics::count_substeps(problem_.model, u, u_next, sizes_.substep) > 1;
  if (recoils) return false;
  const dynamics::StepResult& result = scratch_.step_result;
  const bool own = q != problem_.plan.q_start;  // what penetrates at the start is not its doing
  if (own && calc_penetration(problem_.model, result) > problem_.allowed.penetration) return false;
  if (problem_.press.share(result.contacts, sizes_.exact.h) > problem_.allowed.press) return false;
  q = result.q_next;
  u = u_next;
  dynamics::Knot& knot = segment.knots.emplace_back();
  knot.u = u_next;
  knot.q = q;
  std::copy_if(result.contacts.begin(), result.contacts.end(), std::back_inserter(knot.contacts), [](const auto& c) { return c.active; });
  return true;
}

bool CommandFollower::advance_in_parts(const Eigen::VectorXd& command, Segment& segment, int least) {
  return ramp(command, std::max(least, dynamics::count_substeps(problem_.model, u, command, sizes_.substep)), segment);
}

bool CommandFollower::ramp(const Eigen::VectorXd& command, int parts, Segment& segment) {
  const Eigen::VectorXd u_before = u;
  bool behind = dynamics::count_substeps(problem_.model, u, command, sizes_.substep) > parts;
  for (int k = 1; k <= parts; ++k) {
    const double s = static_cast<double>(k) / parts;
    Eigen::VectorXd next = k == parts ? command : Eigen::VectorXd((1 - s) * u_before + s * command);
    if (behind) next = u + (next - u).cwiseMax(-sizes_.limits).cwiseMin(sizes_.limits);
    if (!advance(next, segment)) return false;
    behind = behind || u != next;
  }
  return true;
}

bool CommandFollower::replay(const Segment& from, Segment& segment) {
  return std::all_of(from.knots.begin(), from.knots.end(), [&](const auto& knot) { return ramp(knot.u, sizes_.cuts, segment); });
}

bool CommandFollower::come_to_rest(Segment& push) {
  constexpr int kMostKnots = 10;
  for (int k = 0; k < kMostKnots * sizes_.cuts; ++k) {
    const Eigen::VectorXd before = q;
    if (!advance(u, push)) return false;
    if (problem_.motion.share(before, q) <= 0.01 / sizes_.cuts) {
      push.knots.pop_back();
      q = before;
      break;
    }
  }
  return true;
}

}  // namespace stiction::planning::refinement
