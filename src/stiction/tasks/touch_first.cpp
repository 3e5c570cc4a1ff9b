#include "stiction/tasks/touch_first.hpp"

#include <algorithm>

#include "stiction/planning/goal_measure.hpp"

namespace stiction::tasks {

namespace {

/// Moves the goal of objects whose support was felt elsewhere together with this support.
void move_goal(const execution::TouchScenario& scenario, const world::Model& felt, Task& task) {
  planning::Goal& goal = task.problem.goal;
  Eigen::VectorXd before = task.problem.q_goal, after = before;
  if (before.size() == 0) return;
  execution::move_objects(scenario, *scenario.arm.model, felt, after);
  if (after == before) return;
  for (const auto& object : felt.objects()) {
    if (object.n_v != 6) continue;
    const Eigen::Vector3d shift = after.segment<3>(object.q_begin) - before.segment<3>(object.q_begin);
    if (goal.region) goal.region->lower.segment<3>(object.v_begin) += shift, goal.region->upper.segment<3>(object.v_begin) += shift;
  }
  task.problem.q_goal = after;
  Eigen::VectorXd q = task.problem.q_start;
  q.head(after.size()) = after;
  goal.X_WG = world::object_pose(felt, q, goal.object);
  task.goal_from_command_line = true;
}

/// Result of a scenario without moves: the world differs from the assumed one, and nothing is felt of that.
void feel_nothing(const execution::TouchScenario& scenario, std::uint64_t seed, execution::GuardedRunResult& out) {
  out = {};
  out.world = execution::make_world(scenario, seed);
  out.model = scenario.arm.model;
  Eigen::VectorXd q_u = scenario.arm.objects;
  execution::move_objects(scenario, *out.model, *out.world, q_u);
  out.q = execution::calc_start(scenario.arm);
  out.q.head(q_u.size()) = q_u;
  out.status = out.run.status = core::Status::Solved;
  out.reached = true;
}

}  // namespace

core::Status touch_first(execution::TouchScenario scenario, const execution::WorldOptions& world, const execution::TouchRunOptions& options,
                         Task& task, execution::GuardedRunResult& out) {
  scenario.arm.plant.contact.friction_scale *= world.friction;
  scenario.arm.plant.mass_scale = world.mass;
  if (scenario.moves.empty()) {
    feel_nothing(scenario, options.seed, out);
  } else {
    (void)execution::run_guarded(scenario, options, out);  // the status is in the result
  }
  std::map<std::string, Eigen::Vector3d> places;
  for (const world::FixedSpec& body : out.model->scene().fixed) {
    const auto known = std::ranges::find(task.model->scene().fixed, body.name, &world::FixedSpec::name);
    if (known->X_WB.p != body.X_WB.p) places[body.name] = body.X_WB.p;
  }
  if (!places.empty()) {
    move_goal(scenario, *out.model, task);
    set_places(task, places);
  }
  set_start(task, out.q);
  return out.status;
}

}  // namespace stiction::tasks
