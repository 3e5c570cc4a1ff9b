#include "stiction/planning/verify.hpp"

#include <algorithm>
#include <functional>

#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using core::Status;

/// Errors of commands that a plan has to survive [joint units].
constexpr double kNoise = 1e-6;
/// What gravity from aside is given time to move: steps for which the last command of an edge is held.
constexpr int kTiltHeld = 3;
constexpr double kRests = 1e-3;  // … or until the objects move by less in a step, in tolerances
/// Keeps errors of objects apart from the draws of the search.
constexpr std::uint64_t kDisturbanceSeed = 0xd157a2bed;

}  // namespace

bool starts_push(const Node& parent, const Node& node) { return node.edge == SegmentKind::Contact && parent.edge != SegmentKind::Contact; }

EdgeVerifier::EdgeVerifier(const Setting& setting, const EdgeSimulator& simulator) : setting_(setting), simulator_(simulator) {
  for (int i = 0; i < dynamics::kDisturbances; ++i)
    friction_.push_back(dynamics::calc_friction_factors(setting.model, setting.chains, setting.options.friction_noise, i));
}

bool EdgeVerifier::verify_edge(const Node& parent, const EdgeReplay& parent_replay, const Node& node, ThreadScratch& scratch,
                               Totals& totals, EdgeReplay& replay, Node* left) const {
  replay.q_fine = node.q;  // says that it was tried, whatever comes out
  const Eigen::MatrixXd fine = simulator_.follow_in_half_steps(parent_replay.q_fine, parent.u, node.commands, true, scratch, totals);
  const Goal& goal = setting_.problem.goal;
  const Eigen::VectorXd before = setting_.goal.difference(parent.q, parent_replay.q_fine);
  const auto share = [&](const Eigen::VectorXd& e) { return world::largest_share(setting_.model, e, goal.tol_position, goal.tol_angle); };
  const auto agrees = [&](Eigen::Index k) {
    const Eigen::VectorXd after = setting_.goal.difference(node.states.col(k), fine.col(k));
    return share(after) <= setting_.options.fidelity_path && share(after - before) <= setting_.options.fidelity_edge;
  };
  const auto holds = [&](const Node& edge, Eigen::MatrixXd& disturbed) {
    return holds_disturbed(edge, parent, parent_replay, scratch, totals, disturbed);
  };
  const Eigen::Index n = node.commands.cols();
  if (fine.cols() == n && agrees(n - 1)) {
    replay.q_fine = fine.col(n - 1);
    return holds(node, replay.disturbed);
  }
  if (left == nullptr || node.edge != SegmentKind::Contact) return false;
  for (Eigen::Index k = fine.cols() / 2 - 1; k >= 0; --k) {  // half of it: at its end things are about to go wrong
    if (!agrees(k)) continue;
    if (!cut_edge(parent, node, k + 1, fine.col(k), *left) || !holds(*left, left->replay.disturbed)) left->q.resize(0);
    break;
  }
  return false;
}

bool EdgeVerifier::disturbs() const {
  return setting_.options.start_noise > 0 || setting_.options.edge_tilt > 0 || setting_.options.friction_noise > 0;
}

int EdgeVerifier::follow_with_noise(const Tree& tree, const std::vector<int>& path, ThreadScratch& scratch, Totals& totals) const {
  core::Random random(setting_.options.seed, 0);
  Eigen::VectorXd q = setting_.problem.q_start, u = tree[0].u;
  int astray = kOnPath;
  const auto lost = [&astray](int otherwise) { return astray == kOnPath ? otherwise : astray; };
  for (const int i : path) {
    const Node& node = tree[i];
    Eigen::MatrixXd commands = node.commands;
    for (auto command : commands.colwise()) {
      for (int j = 0; j < setting_.model.n_a(); ++j) command[j] += setting_.model.scales().joint(j) * random.uniform(-kNoise, kNoise);
    }
    const Eigen::MatrixXd states = simulator_.follow_in_half_steps(q, u, commands, node.edge != SegmentKind::Settle, scratch, totals);
    const bool whole = states.cols() == commands.cols();
    if (states.cols() > 0) q = states.rightCols(1);
    if (commands.cols() > 0) u = commands.rightCols(1);
    const bool held = whole && setting_.goal.share_of_tolerances(node.replay.q_fine, q) <= setting_.options.fidelity_edge;
    if (astray == kOnPath && node.parent >= 0 && !held) astray = i;
    if (!whole) return lost(path.back());
  }
  return setting_.goal.ratio(q) <= setting_.options.share_when_refined() ? kOnPath : lost(path.back());
}

bool EdgeVerifier::cut_edge(const Node& parent, const Node& node, Eigen::Index n, Eigen::VectorXd q_fine, Node& out) const {
  out.parent = node.parent;
  out.edge = node.edge;
  out.commands = node.commands.leftCols(n);
  out.states = node.states.leftCols(n);
  out.q = out.states.rightCols(1);
  out.u = out.commands.rightCols(1);
  out.replay.q_fine = std::move(q_fine);
  out.tried = {node.u};  // it goes wrong from here
  return simulator_.moves(parent, out);
}

bool EdgeVerifier::holds_disturbed(const Node& node, const Node& parent, const EdgeReplay& parent_replay, ThreadScratch& scratch,
                                   Totals& totals, Eigen::MatrixXd& disturbed) const {
  if (!disturbs()) return true;
  disturbed = parent_replay.disturbed;
  const Eigen::VectorXd most = setting_.options.start_noise * setting_.goal.inverse_tolerances().cwiseInverse();
  Eigen::VectorXd error = Eigen::VectorXd::Zero(setting_.model.n_v());
  const Eigen::Index n = node.commands.cols(), held = n > 0 && setting_.options.edge_tilt > 0 ? kTiltHeld : 0;
  for (const Eigen::Index i : farthest_first(parent, disturbed)) {
    Eigen::VectorXd q = disturbed.col(i);
    if (starts_push(parent, node)) {
      core::Random random(setting_.options.seed ^ kDisturbanceSeed,
                          static_cast<std::uint64_t>(dynamics::kDisturbances * parent.pushes + i / 2));
      for (int k = 0; k < setting_.model.n_vu(); ++k) error[k] = (i % 2 == 0 ? 1 : -1) * random.uniform(-most[k], most[k]);
      world::retract(setting_.model, q, error, q);
    }
    scratch.steps.forget();
    for (Eigen::Index k = 0; k < n + held; ++k) {
      if (scratch.stop()) return false;
      const Eigen::VectorXd weights = dynamics::calc_weights_aside(setting_.model, q, setting_.options.edge_tilt, static_cast<int>(i));
      const dynamics::StepInput input{q, node.commands.col(std::min(k, n - 1)), &weights, nullptr, &friction_[static_cast<std::size_t>(i)]};
      if (!totals.add(1, dynamics::step(setting_.model, input, simulator_.exact(), scratch.steps, scratch.step_result))) return false;
      const bool rests = k >= n && setting_.goal.share_of_tolerances(q, scratch.step_result.q_next) < kRests;
      q = scratch.step_result.q_next;
      if (rests) break;
    }
    if (setting_.goal.share_of_tolerances(node.q, q) > 1) return false;
    disturbed.col(i) = q;
  }
  return true;
}

std::array<Eigen::Index, dynamics::kDisturbances> EdgeVerifier::farthest_first(const Node& node, const Eigen::MatrixXd& disturbed) const {
  std::array<double, dynamics::kDisturbances> off{};
  std::array<Eigen::Index, dynamics::kDisturbances> order{};
  for (Eigen::Index i = 0; i < dynamics::kDisturbances; ++i) {
    order[static_cast<std::size_t>(i)] = i;
    off[static_cast<std::size_t>(i)] = setting_.goal.share_of_tolerances(node.q, disturbed.col(i));
  }
  std::ranges::stable_sort(order, std::greater<>{}, [&off](Eigen::Index i) { return off[static_cast<std::size_t>(i)]; });
  return order;
}

}  // namespace stiction::planning
