#include "stiction/planning/refine/problem.hpp"

#include <cmath>

#include "stiction/planning/contact_limits.hpp"

namespace stiction::planning::refinement {

Problem::Problem(const std::shared_ptr<const world::Model>& shared, const Plan& given, const PlannerOptions& planner_options,
                 const RefineOptions& refine_options, const core::RunControl& run_control)
    : Setting({.model = shared, .q_start = given.q_start, .goal = given.goal, .q_goal = {}}, planner_options),
      plan(given),
      refine(refine_options),
      control(run_control),
      motion{goal, thresholds.motionless.position, thresholds.motionless.angle},
      cuts(std::max(1, static_cast<int>(std::ceil(plan.step.h / refine_options.h * (1 - 1e-12))))),
      allowed{kMostPenetration, kMostForceGap, kMostPress} {
  pace = {Pace::Kind::SubSteps, given.step, given.substep, dynamics::Overrun::Accept};
  pace.step.smoothing = dynamics::Exact{};
  pace.step.with_A = pace.step.with_B = false;
  pace.step.warm_start = false;
  pace.step.h = plan.step.h / cuts;
  pace.limits.joint_angle /= cuts;
  pace.limits.joint_travel /= cuts;
  pace.limits.slide /= cuts;
  pace.limits.max_substeps *= cuts;
  halves = {Pace::Kind::HalfSteps, pace.step, {}, {}};
}

std::vector<Push> Problem::shortened(const Plan& given) const {
  std::vector<Push> pushes = split_at_regrasps(given);
  cut_tails(motion, pushes);
  drop_pushes(motion, pushes);
  return pushes;
}

void finish(const Problem& problem, const Cursor& start, const Eigen::VectorXd& q_target, Scratch& scratch, Work& work, Run& run) {
  run.end.fine = start.fine;
  Simulation simulation(problem, scratch, work);
  const Watch watch{.most = problem.allowed};
  run.holds = true;
  for (const Segment& segment : run.segments) {
    run.holds = run.holds && simulation.follow(commands_of(segment.knots), problem.halves, {}, watch, run.end.fine) == Ending::Reached;
    run.end.fine.knots.clear();
  }
  run.holds = run.holds && simulation.ends_well(watch, run.end.fine);
  run.missed = std::max(problem.miss(q_target, run.end.q), problem.miss(q_target, run.end.fine.q));
}

const Eigen::VectorXd& end_of(const Plan& plan) { return plan.segments.empty() ? plan.q_start : plan.segments.back().knots.back().q; }

}  // namespace stiction::planning::refinement
