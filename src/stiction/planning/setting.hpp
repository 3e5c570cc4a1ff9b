#pragma once

#include <memory>
#include <utility>

#include "stiction/contact/geometry_workspace.hpp"
#include "stiction/planning/goal_measure.hpp"
#include "stiction/planning/press_limits.hpp"
#include "stiction/planning/profile.hpp"
#include "stiction/planning/thresholds.hpp"

namespace stiction::planning {

/// A problem, its options and the quantities that follow from them, computed once for all parts of a search or of a refinement.
struct Setting {
  Setting(PlanningProblem given, const PlannerOptions& planner_options)
      : problem(std::move(given)),
        model(*problem.model),
        options(planner_options),
        thresholds(model, problem.goal.object),
        exact(planner_options.step_options(model)),
        chains(model),
        goal(problem),
        press(model, chains, thresholds.brace) {}
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

  const PlanningProblem problem;
  const world::Model& model;
  const PlannerOptions& options;
  const SceneThresholds thresholds;
  const dynamics::StepOptions exact;  ///< options of every exact step
  const world::RobotChains chains;
  const GoalMeasure goal;
  const PressLimits press;
};

/// Memory that one thread needs to simulate commands.
struct SimulationScratch {
  SimulationScratch(const std::shared_ptr<const world::Model>& model, const core::RunControl& control) : steps(model), geometry(*model) {
    geometry.control = &control;
  }
  bool stop() const { return geometry.stop(); }

  dynamics::StepWorkspace steps;
  dynamics::StepResult step_result;
  dynamics::RolloutResult rollout_result;
  contact::GeometryWorkspace geometry;
  ProfileClock profile;
};

}  // namespace stiction::planning
