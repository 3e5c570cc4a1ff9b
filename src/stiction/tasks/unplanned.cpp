#include "stiction/tasks/unplanned.hpp"

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

}  // namespace stiction::tasks
