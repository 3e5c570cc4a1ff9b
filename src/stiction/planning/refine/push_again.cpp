#include "stiction/planning/refine/push_again.hpp"

#include <cmath>
#include <iterator>
#include <utility>

#include "stiction/cone/bounded_least_squares.hpp"

namespace stiction::planning::refinement {
namespace {

/// Steps of the plan's length that a push may take to come to rest.
constexpr int kMostResting = 10;

Eigen::VectorXd within_limits(const world::Model& model, const Eigen::VectorXd& command) {
  return command.cwiseMax(model.lower()).cwiseMin(model.upper());
}

/// Where the simulation of a push came to; the knots become those of the segment.
void take(Trace& trace, Cursor& at, Segment& segment) {
  at.q = std::move(trace.q);
  at.u = std::move(trace.u);
  std::move(trace.knots.begin(), trace.knots.end(), std::back_inserter(segment.knots));
}

/// On to a command.
bool advance(const Problem& problem, const Eigen::VectorXd& command, Scratch& scratch, Work& work, Cursor& at, Segment& segment) {
  Trace trace{.q = std::move(at.q), .u = std::move(at.u)};
  const Watch watch{.most = problem.allowed_at_whole_steps()};
  const Ending ending = Simulation(problem, scratch, work).follow(within_limits(problem.model, command), problem.pace, watch, trace);
  take(trace, at, segment);
  return ending == Ending::Reached;
}

/// Holds the last command until the objects rest: the regularisation holds objects back in every sub-step (S.3), in the world nothing does for long.
bool come_to_rest(const Problem& problem, Scratch& scratch, Work& work, Run& run) {
  Trace trace{.q = run.end.q, .u = run.end.u};
  const Watch watch{.most = problem.allowed_at_whole_steps()};
  bool rests = false;
  const Ending ending =
      Simulation(problem, scratch, work).hold(kMostResting * problem.cuts, problem.rest(), problem.pace, {}, watch, trace, rests);
  take(trace, run.end, run.segments.back());
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
  return come_to_rest(problem, scratch, work, run);
}

}  // namespace stiction::planning::refinement
