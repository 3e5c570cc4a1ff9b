#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <numbers>
#include <string>

#include "stiction/planning/planner.hpp"
#include "stiction/world/model.hpp"
#include "support/paths.hpp"
#include "world/allegro.hpp"

namespace stiction::planning::test {

inline constexpr double kAny = std::numeric_limits<double>::infinity();  // bounds of a region without an end

inline std::shared_ptr<const world::Model> load_model(const std::string& task) {
  return world::Model::make(world::load_scene(stiction::test::source_dir() / "tasks" / (task + ".yaml")));
}

using world::test::allegro_start;

inline PlanningProblem hand_problem() {
  PlanningProblem problem;
  problem.model = load_model("planar_hand");
  problem.q_start.resize(7);
  problem.q_start << 0, 0.35, 0, -0.7853981633974483, -0.7853981633974483, 0.7853981633974483, 0.7853981633974483;
  problem.goal.X_WG = world::object_pose(*problem.model, problem.q_start, 0);
  problem.goal.X_WG.R = Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return problem;
}

inline PlannerOptions hand_options() {
  PlannerOptions options;
  options.threads = 2;
  world::SampleBox box;
  box.lower = Eigen::Vector3d(-0.3, 0.3, -0.01);
  box.upper = Eigen::Vector3d(0.3, 0.5, 3.15);
  options.sample_boxes.push_back(box);
  return options;
}

}  // namespace stiction::planning::test
