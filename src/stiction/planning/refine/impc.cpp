#include "stiction/planning/refine/impc.hpp"

#include <cmath>
#include <utility>

namespace stiction::planning::refinement {
namespace {

/// Σ T (n_v + n_a + kOverhead)³ over the pushes of a trial that iMPC works on, T their steps, is at most this.
constexpr double kMostWork = 2e7;
/// Rows of a matrix whose products take as long as what else is done for it.
constexpr double kOverhead = 20;

/// The object in tolerances of the goal, at the end fully and on its way a little; changes of the command in limits of a sub-step.
trajopt::OptimizeOptions impc_options(const Problem& problem, const StepSizes& sizes, int threads) {
  constexpr double kWay = 1e-2, kChange = 1e-2;
  trajopt::OptimizeOptions options;
  options.step = sizes.exact;
  options.scheme = problem.options.smoothing;
  options.threads = threads;
  options.iterations = problem.refine.mpc_iterations;
  options.qp_tolerance = 1e-3;  // the step is judged by the dynamics
  options.weights.Qd = Eigen::VectorXd::Zero(problem.model.n_v());
  options.weights.Qd.head(problem.model.n_vu()) = problem.goal.inverse_tolerances().cwiseAbs2();
  options.weights.Q = kWay * options.weights.Qd;
  options.weights.R = kChange * sizes.limits.cwiseAbs2().cwiseInverse();
  return options;
}

}  // namespace

bool correct_by_impc(const Start& start, const Eigen::VectorXd& q_target, Scratch& scratch, int threads, double& spent, Run& run,
                     Work& work) {
  const Problem& problem = start.problem;
  if (problem.refine.mpc_iterations == 0) return false;
  std::vector<Eigen::VectorXd> u, reference{start.at.q};
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
  if (!scratch.optimizer) scratch.optimizer.emplace(problem.problem.model, threads);
  const core::Status status =
      trajopt::optimize(problem.model, {start.at.q, u, reference, &start.at.u}, impc_options(problem, start.sizes, threads),
                        problem.control, *scratch.optimizer, scratch.optimized);
  if (status != core::Status::Solved) return false;
  work.steps += scratch.optimized.steps;

  Run corrected;
  corrected.gamma = run.gamma;
  corrected.rests = run.rests;
  CommandFollower follower(problem, start.sizes, start.at.q, start.at.u, start.turn, scratch);
  const auto follow = [&] {
    std::size_t t = 0;
    for (const Segment& from : run.segments) {
      Segment& segment = corrected.segments.emplace_back(Segment{SegmentKind::Contact, {}});
      for (std::size_t k = 0; k < from.knots.size(); ++k) {
        if (!follower.advance_in_parts(scratch.optimized.u[t++], segment)) return false;
      }
    }
    return true;
  };
  const bool followed = follow();
  work += follower.work;
  if (!followed) return false;
  corrected.end.q = follower.q;
  corrected.end.u = follower.u;
  corrected.whole = problem.miss(q_target, corrected.end.q);
  if (corrected.whole >= run.missed) return false;
  finish(start, q_target, scratch, corrected);
  work += corrected.work;
  if (!corrected.holds || corrected.missed >= run.missed) return false;
  run = std::move(corrected);
  return true;
}

}  // namespace stiction::planning::refinement
