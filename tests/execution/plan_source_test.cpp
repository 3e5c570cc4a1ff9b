#include "stiction/execution/closed_loop/plan_source.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "planning/push_plan.hpp"
#include "simulation/scenes.hpp"
#include "stiction/planning/goal_measure.hpp"

namespace stiction::execution::test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// A box of 0.1 m on a slope of tan⁻¹ 0.8 with μ = 1, 0.05 m above a stop, and a ball that pushes it uphill from there.
struct Slope {
  double angle = std::atan(0.8);
  Vector3d uphill{0, std::cos(angle), std::sin(angle)}, normal{0, -std::sin(angle), std::cos(angle)};
  planning::PlanningProblem problem;
  planning::PlannerOptions options;
  RunOptions how;

  Slope() {
    const auto facing = [](const Vector3d& direction, const Vector3d& p) {
      return world::Pose{Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), direction).toRotationMatrix(), p};
    };
    world::Scene scene = simulation::test::empty_scene({0, 0, -9.81});
    scene.objects.push_back(simulation::test::solid(world::ObjectJoint::PlanarYZ, world::Box{{0.05, 0.05, 0.05}}, 0.5, 1));
    scene.fixed.push_back(simulation::test::ground(1, facing(normal, Vector3d::Zero())));
    scene.fixed.push_back(simulation::test::ground(1, facing(uphill, -0.1 * uphill)));
    scene.fixed.back().name = "stop";
    scene.robots.push_back(simulation::test::pusher(500));
    problem.model = world::Model::make(scene);
    problem.q_start = VectorXd::Zero(5);
    const Vector3d box = 0.05 * normal, ball = box - 0.16 * uphill + 0.06 * normal;
    problem.q_start << box.y(), box.z(), angle, ball.y(), ball.z();
    problem.goal.X_WG = world::object_pose(*problem.model, problem.q_start, 0);
    problem.goal.X_WG.p += 0.05 * uphill;
    options.threads = 1;
    options.max_iterations = 30;
  }
};

TEST(PlanSource, StartThatRestsWithTheFrictionOfTheSceneAlone_SlipsInAPlanWithLess) {
  Slope slope;
  const RunSpeeds speeds = calc_run_speeds(*slope.problem.model, 0);
  PlanSource source(slope.problem, slope.options, slope.how, speeds);
  const VectorXd u = slope.problem.q_start.tail(2);
  const Answer less = source.ask({.q = slope.problem.q_start, .u = u, .friction = 0.7}, {});
  EXPECT_TRUE(less.slips);
  EXPECT_NEAR(less.result.start_moved, 0.05, 1e-3) << "as far as the stop";
  EXPECT_FALSE(less.trajectory) << "it would begin where the object came to";
  EXPECT_EQ(less.result.iterations, 0) << "nothing was searched";
  EXPECT_NE(less.result.reason.find("the object does not rest at the start: it moves by"), std::string::npos) << less.result.reason;
  EXPECT_FALSE(source.ask({.q = slope.problem.q_start, .u = u}, {}).slips);
}

/// The box of `planar_pushing`, to be pushed by `way` along both axes [m].
planning::PlanningProblem push_by(double way) {
  planning::PlanningProblem problem;
  problem.model = planning::test::load_model("planar_pushing");
  problem.q_start = planning::test::push_up(problem.model).q_start;
  problem.goal.X_WG = world::object_pose(*problem.model, problem.q_start, 0);
  problem.goal.X_WG.p += Vector3d(0, way, way);
  problem.goal.tol_position = 0.05;
  problem.goal.tol_angle = 0.5;
  return problem;
}

planning::PlannerOptions on_one_thread(int max_iterations) {
  planning::PlannerOptions options;
  options.threads = 1;
  options.max_iterations = max_iterations;
  return options;
}

TEST(PlanSource, ShortSearch_EndsAfterTwiceTheExtensionsOfTheOneBefore) {
  const planning::PlanningProblem problem = push_by(0.2);
  const planning::PlannerOptions options = on_one_thread(3000);
  RunOptions how;
  how.join = false;
  const RunSpeeds speeds = calc_run_speeds(*problem.model, 0);
  PlanSource source(problem, options, how, speeds);
  const VectorXd u = problem.q_start.tail(2);
  EXPECT_EQ(source.found(), 0);
  const Answer near = source.ask({.q = problem.q_start, .u = u, .is_short = true}, {});  // before any other a search is not cut off by one
  ASSERT_EQ(near.result.status, core::Status::Solved) << near.result.reason;
  EXPECT_EQ(source.found(), 1);
  VectorXd far = problem.q_start;
  far.head<2>() += Eigen::Vector2d(300, 300);
  far.tail<2>() += Eigen::Vector2d(300, 300);
  const Answer cut = source.ask({.q = far, .u = far.tail(2), .number = 1, .is_short = true}, {});
  EXPECT_EQ(cut.result.status, core::Status::MaxIterations);
  EXPECT_EQ(cut.result.iterations, std::max<long>(200, 2 * near.result.iterations));
  EXPECT_FALSE(cut.trajectory) << "it comes nearer, but there is a way to start better";
  const Answer whole = source.ask({.q = far, .u = far.tail(2), .number = 2}, {});
  EXPECT_EQ(whole.result.iterations, 3000);
}

/// No plan comes within a thousandth of the tolerances: one within the tolerances will do, once a search has gone on for four times as long.
TEST(PlanSource, PlanWithinTheTolerances_WillDoWhereNoneIsBetter) {
  const planning::PlanningProblem problem = push_by(0.2);
  const planning::PlannerOptions options = on_one_thread(100'000);
  RunOptions how;
  how.plan_fraction = 1e-6;
  const RunSpeeds speeds = calc_run_speeds(*problem.model, 0);
  PlanSource source(problem, options, how, speeds);
  const Answer near = source.ask({.q = problem.q_start, .u = problem.q_start.tail(2)}, {});
  EXPECT_EQ(near.result.status, core::Status::Solved);
  EXPECT_TRUE(near.trajectory);
  EXPECT_LE(near.result.plan.error.share(problem.goal), options.tolerance_fraction);
  EXPECT_GE(near.result.iterations, 1000);
  EXPECT_LT(near.result.iterations, 10'000);
}

TEST(PlanSource, SearchEndsWithTheClockOfTheRun) {
  const planning::PlanningProblem problem = push_by(300);
  const planning::PlannerOptions options = on_one_thread(1'000'000);
  RunOptions how;
  how.planning_rate = 2;
  const RunSpeeds speeds = calc_run_speeds(*problem.model, 0);
  PlanSource source(problem, options, how, speeds);
  const Answer cut = source.ask({.q = problem.q_start, .u = problem.q_start.tail(2), .time_left = 0.1}, {});
  EXPECT_EQ(cut.result.status, core::Status::MaxIterations);
  EXPECT_GE(cut.charge_s, 0.1);
  EXPECT_LT(cut.charge_s, 0.3) << "two processor seconds count as one of the clock";
}

/// Whatever keeps the object where it is, the fourth time in a row the plan that does not move it is not gone on with.
TEST(PlanSource, PlanThatBringsTheObjectNoNearer_IsGivenUp) {
  planning::PlanningProblem problem;
  problem.model = planning::test::load_model("planar_pushing");
  const planning::Plan plan = planning::test::push_up(problem.model);
  problem.q_start = plan.q_start;
  problem.goal = plan.goal;
  problem.goal.tol_position = 0.005;
  planning::PlannerOptions options;
  options.threads = 1;
  options.max_iterations = 1;
  const RunOptions how;
  const RunSpeeds speeds = calc_run_speeds(*problem.model, 0);
  PlanSource stuck(problem, options, how, speeds), moving(problem, options, how, speeds);
  (void)stuck.take(plan), (void)moving.take(plan);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(stuck.ask({.q = plan.q_start, .u = plan.u_start, .number = k}, {}).joined, k < 3) << k;

  std::size_t k = 0;
  double nearest = 1e9;
  for (const auto& knot : plan.segments.back().knots) {
    const double share = planning::goal_error(*problem.model, knot.q, problem.goal).share(problem.goal);
    if (share > nearest - 1.1 || share < 1) continue;
    nearest = share;
    EXPECT_TRUE(moving.ask({.q = knot.q, .u = knot.u, .number = k++}, {}).joined) << share << " tolerances from the goal";
  }
  EXPECT_GE(k, 4U) << "more often than in vain";
}

}  // namespace
}  // namespace stiction::execution::test
