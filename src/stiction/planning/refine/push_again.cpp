#include "stiction/planning/refine/push_again.hpp"

#include <cmath>
#include <iterator>
#include <utility>

#include "stiction/cone/bounded_least_squares.hpp"

namespace stiction::planning::refinement {
namespace {

/// Steps of the plan's length that a push may take to come to rest.
constexpr int kMostResting = 10;
/// Σ T (n_v + n_a + kOverhead)³ over the pushes that iMPC works on, T their steps, is at most this.
constexpr double kMostWork = 2e7;
/// Rows of a matrix whose products take as long as what else is done for it.
constexpr double kOverhead = 20;

Eigen::VectorXd within_limits(const world::Model& model, const Eigen::VectorXd& command) {
  return command.cwiseMax(model.lower()).cwiseMin(model.upper());
}

/// On to a command; the knots become those of the segment.
bool advance(const Problem& problem, const Eigen::VectorXd& command, Scratch& scratch, Work& work, Cursor& at, Segment& segment) {
  Trace trace{.q = std::move(at.q), .u = std::move(at.u)};
  const Watch watch{.most = problem.allowed_at_whole_steps()};
  const Ending ending = Simulation(problem, scratch, work).follow(within_limits(problem.model, command), problem.pace, watch, trace);
  at.q = std::move(trace.q);
  at.u = std::move(trace.u);
  std::move(trace.knots.begin(), trace.knots.end(), std::back_inserter(segment.knots));
  return ending == Ending::Reached;
}

/// The change of the command that moves the objects by e in the smoothed local model where they are, (E.6).
bool calc_feedback(const Problem& problem, const Cursor& at, const Eigen::VectorXd& e, Scratch& scratch, Work& work,
                   Eigen::VectorXd& delta) {
  const world::Model& model = problem.model;
  dynamics::StepOptions smooth = problem.pace.step;
  smooth.smoothing = problem.thresholds.smoothing;
  smooth.with_B = true;
  if (!work.add(1, dynamics::step(model, {at.q, at.u}, smooth, scratch.steps, scratch.step_result))) return false;
  const Eigen::VectorXd& W = problem.goal.inverse_tolerances();
  const Eigen::MatrixXd WB = W.asDiagonal() * scratch.step_result.B.topRows(model.n_vu()) * problem.limits.asDiagonal();
  const auto limited = [&](const Eigen::VectorXd& bound) {
    return Eigen::VectorXd(
        (bound - at.u).cwiseQuotient(problem.limits).cwiseMax(-threshold::kMostFeedback).cwiseMin(threshold::kMostFeedback));
  };
  cone::solve_bounded_least_squares(WB, W.cwiseProduct(e), threshold::kFeedback, limited(model.lower()).cwiseMin(0.0),
                                    limited(model.upper()).cwiseMax(0.0), delta);
  delta = delta.cwiseProduct(problem.limits).eval();
  return true;
}

/// The object in tolerances of the goal, at the end fully and on its way a little; changes of the command in limits of a sub-step.
trajopt::OptimizeOptions impc_options(const Problem& problem) {
  constexpr double kWay = 1e-2, kChange = 1e-2;
  trajopt::OptimizeOptions options;
  options.step = problem.pace.step;
  options.scheme = problem.thresholds.smoothing;
  options.threads = 1;
  options.iterations = problem.refine.mpc_iterations;
  options.qp_tolerance = 1e-3;  // the step is judged by the dynamics
  options.weights.Qd = Eigen::VectorXd::Zero(problem.model.n_v());
  options.weights.Qd.head(problem.model.n_vu()) = problem.goal.inverse_tolerances().cwiseAbs2();
  options.weights.Q = kWay * options.weights.Qd;
  options.weights.R = kChange * problem.limits.cwiseAbs2().cwiseInverse();
  return options;
}

}  // namespace

bool follow_push(const Problem& problem, const Cursor& start, const Push& push, const Eigen::VectorXd& q_target, bool feedback,
                 Scratch& scratch, Work& work, Run& run) {
  const Eigen::VectorXd shift = problem.goal.difference(push.edges.back().knots.back().q, q_target);
  Eigen::VectorXd added = Eigen::VectorXd::Zero(problem.model.n_a()), delta;
  double n = 0, k = 0;
  for (const Segment& edge : push.edges) n += static_cast<double>(edge.knots.size());
  run = Run{.end = start, .led = feedback};
  for (const Segment& edge : push.edges) {
    Segment& segment = run.segments.emplace_back();
    segment.kind = edge.kind;
    for (const auto& knot : edge.knots) {
      if (!advance(problem, knot.u + added, scratch, work, run.end, segment)) return false;
      if (problem.miss(knot.q, run.end.q) > threshold::kStrayed) return false;
      const Eigen::VectorXd e = problem.goal.difference(run.end.q, knot.q) + ++k / n * shift;
      if (feedback && calc_feedback(problem, run.end, e, scratch, work, delta)) added += delta;
    }
  }
  return true;
}

bool come_to_rest(const Problem& problem, Scratch& scratch, Work& work, Run& run) {
  Trace trace{.q = run.end.q, .u = run.end.u};
  const Watch watch{.most = problem.allowed_at_whole_steps()};
  bool rests = false;
  const Ending ending =
      Simulation(problem, scratch, work).hold(kMostResting * problem.cuts, problem.rest(), problem.pace, {}, watch, trace, rests);
  if (ending != Ending::Reached) return false;
  run.end.q = std::move(trace.q);
  run.end.u = std::move(trace.u);
  std::move(trace.knots.begin(), trace.knots.end(), std::back_inserter(run.segments.back().knots));
  run.rests = true;
  return true;
}

bool correct_by_impc(const Problem& problem, const Cursor& start, const Eigen::VectorXd& q_target, Scratch& scratch, double& spent,
                     Work& work, Run& run) {
  if (problem.refine.mpc_iterations == 0) return false;
  std::vector<Eigen::VectorXd> u, reference{start.q};
  for (const Segment& segment : run.segments) {
    for (const auto& knot : segment.knots) {
      u.push_back(knot.u);
      reference.push_back(knot.q);
    }
  }
  reference.back().head(problem.model.n_qu()) = q_target.head(problem.model.n_qu());
  const double more = static_cast<double>(u.size()) * std::pow(problem.model.n_v() + problem.model.n_a() + kOverhead, 3);
  if (spent + more > kMostWork) return false;
  spent += more;
  if (!scratch.optimizer) scratch.optimizer.emplace(problem.problem.model, 1);
  if (trajopt::optimize(problem.model, {start.q, u, reference, &start.u}, impc_options(problem), problem.control, *scratch.optimizer,
                        scratch.optimized) != core::Status::Solved)
    return false;
  work.steps += scratch.optimized.steps;

  Run corrected{.end = start, .led = run.led, .rests = run.rests};
  std::size_t t = 0;
  for (const Segment& from : run.segments) {
    Segment& segment = corrected.segments.emplace_back();
    for (std::size_t k = 0; k < from.knots.size(); ++k) {
      if (!advance(problem, scratch.optimized.u[t++], scratch, work, corrected.end, segment)) return false;
    }
  }
  if (problem.miss(q_target, corrected.end.q) >= run.missed) return false;
  finish(problem, start, q_target, scratch, work, corrected);
  if (!corrected.holds || corrected.missed >= run.missed) return false;
  run = std::move(corrected);
  return true;
}

}  // namespace stiction::planning::refinement
