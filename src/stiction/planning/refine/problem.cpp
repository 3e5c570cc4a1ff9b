#include "stiction/planning/refine/problem.hpp"

#include <algorithm>

#include "stiction/planning/contact_limits.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning::refinement {
namespace {

/// Motion of an object that counts as none [L], [rad].
constexpr double kMotionless = 0.01, kMotionlessAngle = 1e-3;

}  // namespace

Problem::Problem(const std::shared_ptr<const world::Model>& shared, const Plan& given, const PlannerOptions& planner_options,
                 const RefineOptions& refine_options, const core::RunControl& run_control)
    : Setting({.model = shared, .q_start = given.q_start, .goal = given.goal, .q_goal = {}}, planner_options),
      plan(given),
      refine(refine_options),
      control(run_control),
      motion{goal, kMotionless * model.scales().robots().length, kMotionlessAngle},
      q_goal(at_goal(model, end_of(given), given.goal)) {
  set_allowed({});
}

void Problem::set_allowed(const Worst& given) {
  allowed = {std::max(kMostPenetration, given.penetration), std::max(kMostForceGap, given.force_gap), std::max(kMostPress, given.press)};
}

std::vector<Push> Problem::shortened(const Plan& given) const {
  std::vector<Push> pushes = split_at_regrasps(given);
  if (refine.cut_tails) cut_tails(motion, pushes);
  if (refine.drop_pushes) drop_pushes(motion, pushes);
  return pushes;
}

StepSizes::StepSizes(const Problem& problem, int parts)
    : cuts(parts), exact(problem.plan.step), substep(problem.plan.substep), limits(problem.model.n_a()) {
  exact.smoothing = dynamics::Exact{};
  exact.with_A = exact.with_B = false;
  exact.warm_start = false;
  exact.h = problem.plan.step.h / cuts;
  coarse = exact.h > problem.refine.h * (1 + 1e-9);
  substep.joint_angle /= cuts;
  substep.joint_travel /= cuts;
  substep.slide /= cuts;
  substep.max_substeps *= cuts;
  free_substep = substep;
  free_substep.joint_angle = problem.plan.substep.joint_angle;
  free_substep.joint_travel = problem.plan.substep.joint_travel;
  const world::Model& model = problem.model;
  for (int j = 0; j < model.n_a(); ++j) {
    const bool revolute = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].kind == world::DofKind::Revolute;
    limits[j] = revolute ? substep.joint_angle : substep.joint_travel;
  }
}

const Eigen::VectorXd& end_of(const Plan& plan) { return plan.segments.empty() ? plan.q_start : plan.segments.back().knots.back().q; }

}  // namespace stiction::planning::refinement
