#include "stiction/planning/verify.hpp"

#include "stiction/planning/contact_limits.hpp"

namespace stiction::planning {
namespace {

/// Limits of an edge at half its sub-step.
constexpr Worst kMostFine{kMostFinePenetration, kMostForceGap, kMostPress};

}  // namespace

bool verify_edge(const Setting& setting, const Node& parent, const Eigen::VectorXd& parent_fine, const Node& node, ThreadScratch& scratch,
                 Totals& totals, Eigen::VectorXd& q_fine) {
  const ProfileClock::Scope scope(scratch.profile, Activity::HalfSteps);
  q_fine = node.q;  // marks the edge as tried, whatever the outcome
  Simulation simulation(setting, scratch, totals);
  const Watch watch{.most = kMostFine};
  Trace fine{.q = parent_fine, .u = parent.u};
  const std::vector<Eigen::VectorXd> commands = commands_of(node.commands);
  if (simulation.follow(commands, half_steps(setting), {}, watch, fine) != Ending::Reached || !simulation.ends_well(watch, fine))
    return false;
  const PathTolerances& most = setting.goal.tolerances();
  const Eigen::VectorXd before = setting.goal.difference(parent.q, parent_fine), after = setting.goal.difference(node.q, fine.q);
  const auto share = [&](const Eigen::VectorXd& e) { return world::largest_share(setting.model, e, most.position, most.angle); };
  if (share(after) > threshold::kFidelityPath || share(after - before) > threshold::kFidelityEdge) return false;
  q_fine = fine.q;
  return true;
}

bool verify_root(const Setting& setting, const Node& root, ThreadScratch& scratch, Totals& totals, Eigen::VectorXd& q_fine) {
  Trace fine{.q = setting.problem.q_start, .u = root.u};
  const std::vector<Eigen::VectorXd> commands = commands_of(root.commands);
  if (Simulation(setting, scratch, totals).follow(commands, half_steps(setting), {}, {}, fine) != Ending::Reached) return false;
  q_fine = fine.q;
  return true;
}

}  // namespace stiction::planning
