#include "stiction/planning/refine/feedback.hpp"

#include <utility>

#include "stiction/cone/bounded_least_squares.hpp"

namespace stiction::planning::refinement {
namespace {

/// On its way a push is given up farther away than this, in tolerances of the goal.
constexpr double kStrayed = 4;
/// What feedback may add to a command at a knot of the plan, as a share of what a sub-step may.
constexpr double kMostFeedback = 0.3;
/// Knots of the plan's length after a push in which feedback may still take the objects to their target.
constexpr int kMostLeading = 10;

/// The change of the command that moves the objects by e in the smoothed local model where they are, (E.6).
bool calc_feedback(CommandFollower& follower, const Eigen::VectorXd& e, double gamma, Eigen::VectorXd& delta) {
  const Problem& problem = follower.problem();
  const world::Model& model = problem.model;
  const Eigen::VectorXd& limits = follower.sizes().limits;
  Scratch& scratch = follower.scratch();
  dynamics::StepOptions smooth = follower.sizes().exact;
  smooth.smoothing = problem.options.smoothing;
  smooth.with_B = true;
  ++follower.work.steps;
  if (dynamics::step(model, {follower.q, follower.u}, smooth, scratch.steps, scratch.step_result) != core::Status::Solved) return false;
  const Eigen::MatrixXd WB =
      problem.goal.inverse_tolerances().asDiagonal() * scratch.step_result.B.topRows(model.n_vu()) * limits.asDiagonal();
  const Eigen::VectorXd lower = (model.lower() - follower.u).cwiseMin(0.0).cwiseQuotient(limits).cwiseMax(-kMostFeedback);
  const Eigen::VectorXd upper = (model.upper() - follower.u).cwiseMax(0.0).cwiseQuotient(limits).cwiseMin(kMostFeedback);
  cone::solve_bounded_least_squares(WB, problem.goal.inverse_tolerances().cwiseProduct(e), gamma, lower, upper, delta);
  delta = delta.cwiseProduct(limits).eval();
  return true;
}

/// The commands of a push, moved along with feedback on where its objects are against where the plan has them on the way to q_target.
bool go_along(CommandFollower& follower, const Push& push, const Eigen::VectorXd& q_target, double gamma, Way& way) {
  const Problem& problem = follower.problem();
  const world::Model& model = problem.model;
  const Eigen::VectorXd& q_planned = push.edges.back().knots.back().q;
  const Eigen::VectorXd shift = problem.goal.difference(q_planned, q_target);
  Eigen::VectorXd added = Eigen::VectorXd::Zero(model.n_a()), delta;
  std::size_t n = 0, k = 0;
  for (const Segment& edge : push.edges) n += edge.knots.size();
  for (const Segment& edge : push.edges) {
    Segment& segment = way.segments.emplace_back(Segment{edge.kind, {}});
    for (const auto& knot : edge.knots) {
      if (!follower.advance_in_parts(follower.within_limits(knot.u + added), segment, follower.sizes().cuts)) return false;
      if (problem.miss(knot.q, follower.q) > kStrayed) return false;
      const Eigen::VectorXd e = problem.goal.difference(follower.q, knot.q) + static_cast<double>(++k) / static_cast<double>(n) * shift;
      if (gamma != kNoFeedback && calc_feedback(follower, e, gamma, delta)) added += delta;
    }
  }
  return true;
}

/// On from the end of a push, for as long as that brings the objects nearer.
bool lead(CommandFollower& follower, const Eigen::VectorXd& q_target, const Run& run, Segment& segment) {
  const Problem& problem = follower.problem();
  Eigen::VectorXd delta;
  double missed = problem.miss(q_target, follower.q);
  for (int k = 0; k < kMostLeading && missed > problem.refine.miss; ++k) {
    if (!calc_feedback(follower, problem.goal.difference(follower.q, q_target), run.gamma, delta)) return true;
    const Eigen::VectorXd q = follower.q, u = follower.u;
    const std::size_t size = segment.knots.size();
    if (!follower.advance_in_parts(follower.within_limits(follower.u + delta), segment, follower.sizes().cuts)) return false;
    if (run.rests && !follower.come_to_rest(segment)) return false;
    const double now = problem.miss(q_target, follower.q);
    if (now < missed) {
      missed = now;
    } else {
      segment.knots.resize(size);
      follower.q = q;
      follower.u = u;
      return true;
    }
  }
  return true;
}

}  // namespace

bool push_with_feedback(CommandFollower& follower, const Push& push, const Eigen::VectorXd& q_target, Run& run) {
  Way& way = *run.way;
  if (!way.known) {
    const Work before = std::exchange(follower.work, {});
    way.segments.clear();
    way.good = go_along(follower, push, q_target, run.gamma, way);
    way.known = !follower.stop();
    way.q = follower.q;
    way.u = follower.u;
    way.work = std::exchange(follower.work, before);
  }
  if (!way.good) return false;
  run.segments = way.segments;
  follower.q = way.q;
  follower.u = way.u;
  if (run.rests && !follower.come_to_rest(run.segments.back())) return false;
  return run.gamma == kNoFeedback || lead(follower, q_target, run, run.segments.back());
}

}  // namespace stiction::planning::refinement
