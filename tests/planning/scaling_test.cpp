// Plans in other units: the same task, smaller or larger, has the same plan.
#include <filesystem>
#include <fstream>
#include <limits>
#include <regex>
#include <sstream>

#include "planning/systems.hpp"
#include "stiction/planning/default_options.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

/// models/planar_pusher.urdf with a ball of another radius.
std::filesystem::path pusher_of(double radius) {
  std::ifstream in(stiction::test::source_dir() / "models" / "planar_pusher.urdf");
  std::stringstream text;
  text << in.rdbuf();
  const auto file = stiction::test::folder_of_the_process() / ("pusher_" + std::to_string(radius) + ".urdf");
  std::ofstream(file) << std::regex_replace(text.str(), std::regex("radius=\"0.1\""), "radius=\"" + std::to_string(radius) + "\"");
  return file;
}

/// tasks/planar_pushing.yaml with every length times s: there is no gravity, the mass plays no part, and the stiffness stays.
PlanningProblem pushing(double s) {
  world::Scene scene = world::load_scene(stiction::test::source_dir() / "tasks" / "planar_pushing.yaml");
  scene.contact_distance *= s;
  auto& hand = scene.robots[0];
  hand.urdf = pusher_of(0.1 * s);
  hand.effort = {{"y", std::numeric_limits<double>::infinity()}, {"z", std::numeric_limits<double>::infinity()}};
  auto& box = scene.objects[0];
  box.inertia *= s * s;
  std::get<world::Box>(box.geometries[0].shape).half_extents *= s;
  PlanningProblem problem;
  problem.model = world::Model::make(scene);
  problem.q_start.resize(5);
  problem.q_start << 0, 0.5 * s, 0, 0, -0.1 * s;
  problem.goal.X_WG = world::object_pose(*problem.model, problem.q_start, 0);
  problem.goal.X_WG.p.z() = -0.5 * s;
  problem.goal.tol_position = 0.02 * s;
  return problem;
}

TEST(Scaling, TaskOfAnotherSize_IsPlannedAsFast) {
  long first = 0;
  for (const double s : {1.0, 1.0 / 64, 1.0 / 8, 8.0, 64.0}) {
    const PlanningProblem problem = pushing(s);
    PlannerOptions options = default_options(*problem.model, 0);
    options.max_iterations = 20000;
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved) << s;
    if (first == 0) first = result.iterations;
    EXPECT_LT(result.iterations, 3 * first) << s;
  }
}

}  // namespace
}  // namespace stiction::planning::test
