#include "tasks/scripted_plan.hpp"

#include <stdexcept>

#include "stiction/dynamics/rollout.hpp"
#include "stiction/planning/thresholds.hpp"

namespace stiction::tasks {

ScriptedPlan run_script(Task task, const std::vector<Eigen::VectorXd>& commands) {
  ScriptedPlan out;
  planning::Plan& plan = out.result.plan;
  plan.q_start = task.problem.q_start;
  plan.u_start = task.problem.q_start.tail(task.model->n_a());
  plan.step = task.options.step_options(*task.model);
  plan.step.warm_start = false;
  plan.substep = planning::SceneThresholds(*task.model, task.problem.goal.object).substep;
  dynamics::StepWorkspace work(task.model);
  Eigen::VectorXd q = plan.q_start, u = plan.u_start;
  for (const auto& command : commands) {
    dynamics::RolloutResult rollout;
    if (dynamics::rollout(*task.model, q, u, command, plan.step, plan.substep, work, rollout) != core::Status::Solved) {
      throw std::runtime_error("the script of a test plan fails: " + std::string(core::to_string(rollout.status)));
    }
    planning::Segment& segment = plan.segments.emplace_back();
    segment.kind = planning::SegmentKind::Contact;
    segment.knots = rollout.knots;
    q = rollout.knots.back().q;
    u = rollout.knots.back().u;
  }
  plan.goal = task.problem.goal;
  plan.goal.X_WG = world::object_pose(*task.model, q, plan.goal.object);
  plan.error = planning::goal_error(*task.model, q, plan.goal);
  task.problem.goal = plan.goal;
  out.result.status = core::Status::Solved;
  out.result.iterations = 12;
  out.result.wall_s = 0.25;
  out.task = std::move(task);
  out.file = make_plan_file(out.task, out.task.options, out.result, "plan.json");
  return out;
}

ScriptedPlan push_box() {
  Task task = load_task("planar_pushing");
  const Eigen::VectorXd u = task.problem.q_start.tail(2);
  return run_script(std::move(task), {u + Eigen::Vector2d(0.05, -0.02), u + Eigen::Vector2d(0.05, 0.3), u + Eigen::Vector2d(0.05, 0.2)});
}

ScriptedPlan squeeze_ball() {
  Task task = load_task("allegro_ball");
  const Eigen::VectorXd u = task.problem.q_start.tail(16);
  Eigen::VectorXd closed = u;
  for (const int j : {1, 2, 5, 6, 9, 10, 14, 15}) closed[j] += 0.1;
  return run_script(std::move(task), {closed, u});
}

}  // namespace stiction::tasks
