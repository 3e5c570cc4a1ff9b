#pragma once

#include "stiction/tasks/plan_file.hpp"

namespace stiction::tasks {

/// A task and a plan of it that was made by moving the commands along a script with the exact dynamics, without the planner. The
/// goal is where the object ends.
struct ScriptedPlan {
  Task task;
  planning::PlanResult result;
  PlanFile file;
};

/// Moves the commands from one to the next, in a contact segment each. The goal of the task becomes where its object ends.
ScriptedPlan run_script(Task task, const std::vector<Eigen::VectorXd>& commands);

/// planar_pushing: the hand moves below the box and pushes it.
ScriptedPlan push_box();

/// allegro_ball: all fingers close by a tenth of a radian and open again.
ScriptedPlan squeeze_ball();

}  // namespace stiction::tasks
