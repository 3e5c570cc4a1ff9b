// Plans that forgive what is not as planned: noise of commands, of starts, of the floor and its friction.
#include <limits>
#include <set>

#include "planning/simulated_plan.hpp"
#include "planning/systems.hpp"
#include "stiction/planning/thresholds.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

/// What rests on the sixth digit of a command is no plan: at half the sub-step, with other errors than those that the planner tried.
TEST(Planner, Plan_SurvivesNoiseInItsCommands) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  for (options.seed = 0; options.seed < 4; ++options.seed) {
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved);
    core::Random random(99, options.seed);
    for (auto& segment : result.plan.segments) {
      for (auto& knot : segment.knots) {
        for (double& value : knot.u) value += random.uniform(-1e-6, 1e-6);
      }
    }
    EXPECT_TRUE(goal_error(*problem.model, simulate(problem, result.plan, 2), problem.goal).within(problem.goal))
        << "seed " << options.seed;
  }
}

/// Pushes that start with the object somewhere else, by errors that the planner has not drawn, end near enough all the same.
TEST(Planner, StartNoise_PlansForgiveErrorsOfThePushesBefore) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.margins = true;
  dynamics::StepWorkspace work(problem.model);
  dynamics::StepResult r;
  core::Random random(99, 0);
  int runs = 0, reached = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    options.seed = seed;
    PlanResult result;
    ASSERT_EQ(plan(problem, options, {}, result), Status::Solved);
    for (int draw = 0; draw < 5; ++draw) {
      Eigen::VectorXd q = problem.q_start, delta = Eigen::VectorXd::Zero(problem.model->n_v());
      SegmentKind before = SegmentKind::Settle;
      for (const auto& segment : result.plan.segments) {
        if (segment.kind == SegmentKind::Contact && before != SegmentKind::Contact) {
          const double e = threshold::kStartNoise, x = e * problem.goal.tol_position, angle = e * problem.goal.tol_angle;
          delta.head<3>() << random.uniform(-x, x), random.uniform(-x, x), random.uniform(-angle, angle);
          world::retract(*problem.model, q, delta, q);
        }
        before = segment.kind;
        for (const auto& knot : segment.knots) {
          ASSERT_EQ(dynamics::step(*problem.model, {q, knot.u}, result.plan.step, work, r), Status::Solved);
          q = r.q_next;
        }
      }
      ++runs;
      reached += goal_error(*problem.model, q, problem.goal).within(problem.goal);
    }
  }
  EXPECT_GE(reached, 0.8 * runs) << "of " << runs;
}

/// A body of 0.5 kg on a floor of friction 0.5, that the pusher on two sliders is to push by 0.2 m.
PlanningProblem floor_problem(const world::Shape& shape) {
  world::Scene scene = load_model("planar_pushing")->scene();
  scene.gravity = Eigen::Vector3d(0, 0, -9.8);
  scene.objects[0].joint = world::ObjectJoint::Free;
  scene.objects[0].mass = 0.5;
  scene.objects[0].inertia = 0.013 * Eigen::Matrix3d::Identity();
  scene.objects[0].geometries = {{.name = "body", .shape = shape, .X_BG = {}, .friction = 0.5}};
  scene.fixed.push_back(
      {.name = "ground", .X_WB = {}, .geometries = {{.name = "floor", .shape = world::HalfSpace{}, .X_BG = {}, .friction = 0.5}}});
  PlanningProblem problem;
  problem.model = world::Model::make(scene);
  problem.goal.tol_position = 0.03;
  problem.q_start.resize(9);
  problem.q_start << 0, 0.35, 0.2, 0, 0, 0, 1, 0, 0.2;
  problem.goal.X_WG.p = Eigen::Vector3d(0, 0.55, 0.2);
  problem.goal.region = GoalRegion{Eigen::VectorXd::Constant(6, -std::numeric_limits<double>::infinity()),
                                   Eigen::VectorXd::Constant(6, std::numeric_limits<double>::infinity())};
  problem.goal.region->lower[1] = problem.goal.region->upper[1] = 0.55;
  return problem;
}

PlanResult plan_over_the_floor(const PlanningProblem& problem, bool margins, std::uint64_t seed = 0) {
  PlannerOptions options;
  options.seed = seed;
  options.threads = 1;
  options.max_iterations = 2000;
  options.goal_bias = 0.7;
  options.margins = margins;
  world::SampleBox box;
  box.lower = (Eigen::VectorXd(6) << -0.1, 0.3, 0.2, 0, 0, 0).finished();
  box.upper = (Eigen::VectorXd(6) << 0.1, 0.6, 0.2, 0, 0, 0).finished();
  options.sample_boxes.push_back(box);
  PlanResult result;
  (void)plan(problem, options, {}, result);
  return result;
}

Status push_over_the_floor(const PlanningProblem& problem, bool margins) { return plan_over_the_floor(problem, margins).status; }

/// A cube stays on a slope up to atan μ; a ball that nothing holds stays on none.
TEST(Planner, Margins_WhatDoesNotStayOnASlopeIsNotBuiltOn) {
  const PlanningProblem cube = floor_problem(world::Box{Eigen::Vector3d::Constant(0.2)}), ball = floor_problem(world::Sphere{0.2});
  EXPECT_EQ(push_over_the_floor(cube, false), Status::Solved);
  EXPECT_EQ(push_over_the_floor(cube, true), Status::Solved);
  EXPECT_EQ(push_over_the_floor(ball, false), Status::Solved);
  EXPECT_EQ(push_over_the_floor(ball, true), Status::MaxIterations);
}

/// On a slope of 2 : 5 a cube stays with a μ of 0.5, and not with less by 30 %.
TEST(Planner, Margins_WhatNeedsAllItsFrictionIsNotBuiltOn) {
  PlanningProblem cube = floor_problem(world::Box{Eigen::Vector3d::Constant(0.2)});
  world::Scene scene = cube.model->scene();
  scene.gravity = Eigen::Vector3d(0, 4, -10);
  cube.model = world::Model::make(scene);
  EXPECT_EQ(push_over_the_floor(cube, false), Status::Solved);
  EXPECT_EQ(push_over_the_floor(cube, true), Status::MaxIterations);
}

/// The first trees have 0.7 of the friction. On the slope the cube would not rest with it, so that all have that of the scene.
TEST(Planner, FirstTrees_HaveLessFrictionWhereTheStartRestsWithIt) {
  const PlanningProblem level = floor_problem(world::Box{Eigen::Vector3d::Constant(0.2)});
  PlanningProblem slope = level;
  world::Scene scene = slope.model->scene();
  scene.gravity = Eigen::Vector3d(0, 4, -10);
  slope.model = world::Model::make(scene);
  std::set<double> on_level, on_slope;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const PlanResult flat = plan_over_the_floor(level, false, seed), tilted = plan_over_the_floor(slope, false, seed);
    if (flat.status == Status::Solved) on_level.insert(flat.plan.step.friction_scale);
    if (tilted.status == Status::Solved) on_slope.insert(tilted.plan.step.friction_scale);
  }
  EXPECT_EQ(on_level, std::set<double>{0.7});
  EXPECT_EQ(on_slope, std::set<double>{1});
}

}  // namespace
}  // namespace stiction::planning::test
