#include "stiction/planning/refine/regrasp_again.hpp"

#include <cmath>
#include <utility>

namespace stiction::planning::refinement {
namespace {

/// Where the push needs the objects, with the distance that they may be away from it.
Place wanted(const Problem& problem, const Push& push) {
  const PathTolerances& tolerances = problem.goal.tolerances();
  return {&push.q_entry, {threshold::kFarOff * tolerances.position, threshold::kFarOff * tolerances.angle}};
}

RegraspSizes sizes_of(const Problem& problem, const Push& push, double clearance) {
  RegraspSizes sizes{.pace = problem.pace,
                     .free_limits = problem.pace.limits,
                     .cuts = problem.cuts,
                     .clearance = clearance,
                     .most = problem.allowed_at_whole_steps(),
                     .also = wanted(problem, push)};
  // Far from everything, commands move as far in a step as in the plan.
  sizes.free_limits->joint_angle = problem.plan.substep.joint_angle;
  sizes.free_limits->joint_travel = problem.plan.substep.joint_travel;
  return sizes;
}

/// Branches that go to another posture. In u_kept, the other branches have their commands at the start of the push.
world::ChainMask branches_that_move(const Problem& problem, const Cursor& start, const Push& push, Eigen::VectorXd& u_kept) {
  world::ChainMask moving = 0;
  const int n_qu = problem.model.n_qu();
  u_kept = start.u;
  for (int c = 0; c < problem.chains.size(); ++c) {
    double posture = 0;
    for (const int j : problem.chains.joints(c))
      posture = std::max(posture, std::abs(push.q_entry[n_qu + j] - start.q[n_qu + j]) / problem.model.scales().joint(j));
    if (posture > threshold::kMovedBranch) {
      moving |= world::ChainMask{1} << c;
    } else {
      for (const int j : problem.chains.joints(c)) u_kept[j] = push.u_entry[j];
    }
  }
  return moving;
}

bool take(RegraspSimulation& simulation, bool unstable, Run& run) {
  run.end.q = simulation.at().q;
  run.end.u = simulation.at().u;
  if (simulation.knots().empty()) return true;
  run.segments.push_back({SegmentKind::Regrasp, std::move(simulation.knots()), unstable});
  return true;
}

}  // namespace

bool regrasp_again(const Problem& problem, const Cursor& start, const Push& push, std::size_t number, double clearance, Scratch& scratch,
                   Work& work, Run& run) {
  run = Run{.end = start, .clearance = clearance};
  Eigen::VectorXd u_kept;
  const world::ChainMask moving = branches_that_move(problem, start, push, u_kept);
  const RegraspSizes sizes = sizes_of(problem, push, clearance);
  RegraspSimulation simulation(problem, sizes, start.q, start.u, scratch, work);
  bool clear = false;
  if (simulation.let_go(u_kept, moving, moving, clear) != Ending::Reached) return false;
  if (moving == 0) return simulation.hold() == Ending::Reached && take(simulation, false, run);
  const bool unstable = !simulation.is_stable();
  Eigen::VectorXd posture = simulation.at().q.tail(problem.model.n_a());
  for (const int j : problem.chains.joints_of(moving)) posture[j] = push.q_entry[problem.model.n_qu() + j];
  core::Random random(problem.refine.seed, number);
  std::vector<Eigen::VectorXd> path;
  return simulation.find_path(moving, posture, random, path) && simulation.go(moving, path, push.u_entry) == Ending::Reached &&
         simulation.is_free_on_its_way() && take(simulation, unstable, run);
}

bool regrasp_as_planned(const Problem& problem, const Cursor& start, const Push& push, Scratch& scratch, Work& work, Run& run) {
  run = Run{.end = start};
  Trace trace{.q = start.q, .u = start.u};
  const Watch watch{.most = problem.allowed_at_whole_steps()};
  Simulation simulation(problem, scratch, work);
  std::vector<Eigen::VectorXd> commands{push.u_regrasp};
  for (const auto& knot : push.regrasp->knots) commands.push_back(knot.u);
  if (simulation.follow(commands, problem.pace, {}, watch, trace) != Ending::Reached) return false;
  if (!is_free_on_its_way(problem.model, problem.chains, trace.knots, scratch.geometry)) return false;
  run.end.q = std::move(trace.q);
  run.end.u = std::move(trace.u);
  run.segments.push_back({SegmentKind::Regrasp, std::move(trace.knots), push.regrasp->unstable});
  return true;
}

}  // namespace stiction::planning::refinement
