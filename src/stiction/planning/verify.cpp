#include "stiction/planning/verify.hpp"

#include "stiction/planning/contact_limits.hpp"

namespace stiction::planning {
namespace {

/// Keeps the random errors of objects apart from the draws of the search.
constexpr std::uint64_t kDisturbanceSeed = 0xd157a2bed;
/// Limits of an edge at half its sub-step.
constexpr Worst kMostFine{kMostFinePenetration, kMostForceGap, kMostPress};

}  // namespace

bool starts_push(const Node& parent, const Node& node) { return node.edge == SegmentKind::Contact && parent.edge != SegmentKind::Contact; }

EdgeVerifier::EdgeVerifier(const Setting& setting, std::uint64_t seed) : setting_(setting), seed_(seed) {
  for (int i = 0; i < dynamics::kDisturbances; ++i)
    friction_.push_back(dynamics::calc_friction_factors(setting.model, setting.chains, threshold::kFrictionNoise, i));
}

bool EdgeVerifier::verify_edge(const Node& parent, const EdgeReplay& parent_replay, const Node& node, ThreadScratch& scratch,
                               Totals& totals, EdgeReplay& replay) const {
  const ProfileClock::Scope scope(scratch.profile, Activity::HalfSteps);
  replay.q_fine = node.q;  // marks the edge as tried, whatever the outcome
  Simulation simulation(setting_, scratch, totals);
  const Watch watch{.most = kMostFine};
  Trace fine{.q = parent_replay.q_fine, .u = parent.u};
  const std::vector<Eigen::VectorXd> commands = commands_of(node.commands);
  if (simulation.follow(commands, half_steps(setting_), {}, watch, fine) != Ending::Reached || !simulation.ends_well(watch, fine))
    return false;
  const PathTolerances& most = setting_.goal.tolerances();
  const Eigen::VectorXd before = setting_.goal.difference(parent.q, parent_replay.q_fine), after = setting_.goal.difference(node.q, fine.q);
  const auto share = [&](const Eigen::VectorXd& e) { return world::largest_share(setting_.model, e, most.position, most.angle); };
  if (share(after) > threshold::kFidelityPath || share(after - before) > threshold::kFidelityEdge) return false;
  replay.q_fine = fine.q;
  return holds_disturbed(node, parent, parent_replay, scratch, totals, replay.disturbed);
}

bool EdgeVerifier::verify_root(const Node& root, ThreadScratch& scratch, Totals& totals, EdgeReplay& replay) const {
  Trace fine{.q = setting_.problem.q_start, .u = root.u};
  const std::vector<Eigen::VectorXd> commands = commands_of(root.commands);
  if (Simulation(setting_, scratch, totals).follow(commands, half_steps(setting_), {}, {}, fine) != Ending::Reached) return false;
  replay.q_fine = fine.q;
  if (setting_.options.margins) replay.disturbed = root.q.replicate(1, dynamics::kDisturbances);
  return true;
}

bool EdgeVerifier::holds_disturbed(const Node& node, const Node& parent, const EdgeReplay& parent_replay, ThreadScratch& scratch,
                                   Totals& totals, Eigen::MatrixXd& disturbed) const {
  if (!setting_.options.margins) return true;
  const ProfileClock::Scope scope(scratch.profile, Activity::Disturbances);
  disturbed = parent_replay.disturbed;
  Simulation simulation(setting_, scratch, totals);
  const Pace steps{Pace::Kind::Steps, setting_.exact, {}, {}};
  const std::vector<Eigen::VectorXd> commands = commands_of(node.commands);
  for (int draw = 0; draw < dynamics::kDisturbances; ++draw) {
    const Disturbance disturbance{&friction_[static_cast<std::size_t>(draw)], threshold::kEdgeTilt, draw};
    Trace at{.q = disturbed.col(draw), .u = parent.u};
    if (starts_push(parent, node)) move_objects(parent, draw, at.q);
    scratch.steps.forget();
    bool rests = false;
    if (simulation.follow(commands, steps, disturbance, {}, at) != Ending::Reached ||
        simulation.hold(commands.empty() ? 0 : threshold::kTiltHeld, setting_.thresholds.rest, steps, disturbance, {}, at, rests) !=
            Ending::Reached)
      return false;
    if (setting_.goal.share_of_tolerances(node.q, at.q) > 1) return false;
    disturbed.col(draw) = at.q;
  }
  return true;
}

void EdgeVerifier::move_objects(const Node& parent, int draw, Eigen::VectorXd& q) const {
  const Eigen::VectorXd most = threshold::kStartNoise * setting_.goal.inverse_tolerances().cwiseInverse();
  core::Random random(seed_ ^ kDisturbanceSeed, static_cast<std::uint64_t>(dynamics::kDisturbances * parent.pushes + draw / 2));
  Eigen::VectorXd error = Eigen::VectorXd::Zero(setting_.model.n_v());
  for (int k = 0; k < setting_.model.n_vu(); ++k) error[k] = (draw % 2 == 0 ? 1 : -1) * random.uniform(-most[k], most[k]);
  world::retract(setting_.model, q, error, q);
}

}  // namespace stiction::planning
