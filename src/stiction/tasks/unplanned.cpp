#include "stiction/tasks/unplanned.hpp"

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/thresholds.hpp"

namespace stiction::tasks {

planning::PlanResult make_unplanned(const Task& task) {
  planning::PlanResult out;
  planning::Plan& plan = out.plan;
  plan.q_start = task.problem.q_start;
  plan.u_start = plan.q_start.tail(task.model->n_a());
  plan.goal = task.problem.goal;
  plan.segments.push_back({planning::SegmentKind::Settle, {{.u = plan.u_start, .q = plan.q_start, .contacts = {}}}});
  plan.error = planning::goal_error(*task.model, plan.q_start, plan.goal);
  out.status = core::Status::MaxIterations;
  return out;
}

planning::PlanResult make_commanded(const Task& task, const Eigen::MatrixXd& commands, const Eigen::VectorXd& u_start) {
  const world::Model& model = *task.model;
  core::require_size("commands", commands.rows(), model.n_a());
  if (!commands.allFinite()) core::throw_invalid("commands", "numbers that are not finite", "positions of the joints [rad or m]");
  if (u_start.size() > 0) core::require_size("u_start", u_start.size(), model.n_a());
  planning::PlanResult out;
  planning::Plan& plan = out.plan;
  plan.q_start = task.problem.q_start;
  plan.u_start = u_start.size() > 0 ? u_start : Eigen::VectorXd(plan.q_start.tail(model.n_a()));
  plan.goal = task.problem.goal;
  plan.step = task.options.step_options(model);
  plan.substep = planning::SceneThresholds(model, plan.goal.object).substep;
  plan.segments.push_back({planning::SegmentKind::Contact, {}});
  auto& knots = plan.segments.back().knots;
  dynamics::StepWorkspace work(task.model);
  dynamics::RolloutResult rolled;
  Eigen::VectorXd q = plan.q_start, u = plan.u_start;
  out.status = core::Status::Solved;
  for (Eigen::Index k = 0; k < commands.cols() && out.status == core::Status::Solved; ++k) {
    out.status = dynamics::rollout(model, q, u, commands.col(k), plan.step, plan.substep, work, rolled);
    out.steps += rolled.steps;
    for (dynamics::Knot& knot : rolled.knots) knots.push_back(std::move(knot));
    if (!knots.empty()) q = knots.back().q, u = knots.back().u;
  }
  if (knots.empty()) knots.push_back({.u = u, .q = q, .contacts = {}});
  plan.error = planning::goal_error(model, q, plan.goal);
  if (out.status == core::Status::Solved && !plan.error.within(plan.goal)) out.status = core::Status::MaxIterations;
  return out;
}

}  // namespace stiction::tasks
