#include "stiction/planning/refine/problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "stiction/planning/force_gap.hpp"

namespace stiction::planning::refinement {
namespace {

/// Rows of a matrix whose products take as long as what else is done for it.
constexpr double kOverhead = 20;

}  // namespace

Problem::Problem(std::shared_ptr<const world::Model> shared, const Plan& given, const PlannerOptions& planner_options,
                 const RefineOptions& refine_options, const core::RunControl& run_control)
    : shared_model(std::move(shared)),
      model(*shared_model),
      plan(given),
      options(planner_options),
      refine(refine_options),
      control(run_control),
      space(model),
      motion(model, refine_options.motionless_position, refine_options.motionless_angle),
      chains(model),
      press(model, chains, planner_options.brace_force),
      weights(inverse_tolerances(model, given.goal)),
      q_goal(at_goal(model, end_of(given), given.goal)) {
  set_allowed({});
}

void Problem::set_allowed(const Worst& given) {
  allowed = {std::max(kMostPenetration, given.penetration), std::max(kMostForceGap, given.force_gap), std::max(kMostPress, given.press)};
}

double Problem::miss(const Eigen::VectorXd& q_target, const Eigen::VectorXd& q) const {
  Eigen::VectorXd e(model.n_vu());
  space.error(q_target.data(), q.data(), e.data());
  return largest_share(model, e, plan.goal.tol_position, plan.goal.tol_angle);
}

bool Problem::reaches_goal(const Eigen::VectorXd& q, const Eigen::VectorXd& q_fine, double fraction) const {
  const auto within = [&](const GoalError& error) {
    return error.position <= fraction * plan.goal.tol_position && error.angle <= fraction * plan.goal.tol_angle;
  };
  return within(goal_error(model, q, plan.goal)) && within(goal_error(model, q_fine, plan.goal));
}

double Problem::cost(long steps) const { return static_cast<double>(steps) * std::pow(model.n_v() + model.n_a() + kOverhead, 3); }

const Eigen::VectorXd& end_of(const Plan& plan) { return plan.segments.empty() ? plan.q_start : plan.segments.back().knots.back().q; }

}  // namespace stiction::planning::refinement
