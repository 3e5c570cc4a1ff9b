// Goal regions, and plans that get cheaper.
#include <atomic>
#include <limits>

#include "planning/systems.hpp"
#include "support/message_of.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

TEST(GoalRegion, AngleOnly_IsReachedSoonerAndPositionMayBeAny) {
  PlanningProblem whole = hand_problem(), angle = whole;
  angle.goal.region = GoalRegion{Eigen::Vector3d(-kAny, -kAny, 1.5), Eigen::Vector3d(kAny, kAny, 1.5)};
  long iterations_whole = 0, iterations_angle = 0;
  double farthest = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    PlannerOptions options = hand_options();
    options.seed = seed;
    PlanResult a, b;
    ASSERT_EQ(plan(whole, options, {}, a), Status::Solved);
    ASSERT_EQ(plan(angle, options, {}, b), Status::Solved);
    iterations_whole += a.iterations;
    iterations_angle += b.iterations;
    EXPECT_LT(b.plan.error.angle, angle.goal.tol_angle);
    farthest = std::max(farthest, goal_error(*whole.model, b.plan.segments.back().knots.back().q, whole.goal).position);
  }
  EXPECT_LT(iterations_angle, iterations_whole);
  EXPECT_GT(farthest, whole.goal.tol_position) << "position was never used: the test says nothing";
}

TEST(GoalRegion, Mistakes_AreRefused) {
  PlanningProblem problem = hand_problem();
  PlanResult result;
  const auto message = [&] { return stiction::test::message_of([&] { (void)plan(problem, hand_options(), {}, result); }); };
  problem.goal.region = GoalRegion{Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0)};
  EXPECT_EQ(message(), "goal.region.lower: got 2 numbers, expected 3");
  problem.goal.region = GoalRegion{Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0.5, 0)};
  EXPECT_EQ(message(), "goal.region: got ball/z in [1, 0.5], expected lower ≤ upper");
}

TEST(Anytime, CostFallsAndTheFirstPlanIsTheUsualOne) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  PlanResult once, result;
  ASSERT_EQ(plan(problem, options, {}, once), Status::Solved);
  ASSERT_EQ(once.improvements.size(), 1U);
  options.anytime = true;
  options.max_iterations = 10000;
  double shown = std::numeric_limits<double>::infinity();
  core::RunControl control;
  control.on_progress = [&](const core::Progress& p) {
    if (!p.cost) return;
    EXPECT_LE(*p.cost, shown);
    shown = *p.cost;
  };
  ASSERT_EQ(plan(problem, options, control, result), Status::Solved);
  EXPECT_EQ(result.iterations, 10000);
  ASSERT_GE(result.improvements.size(), 2U) << "nothing to say";
  EXPECT_EQ(result.improvements.front().cost, once.cost);
  for (std::size_t i = 1; i < result.improvements.size(); ++i) EXPECT_LT(result.improvements[i].cost, result.improvements[i - 1].cost);
  EXPECT_EQ(result.cost, result.improvements.back().cost);
  EXPECT_NEAR(result.cost, path_cost(*problem.model, result.plan, {}), 1e-12);
  EXPECT_TRUE(result.plan.error.within(problem.goal));
}

TEST(Anytime, Cancelled_KeepsTheBest) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.anytime = true;
  std::atomic<bool> cancel = false;
  core::RunControl control;
  control.cancel = &cancel;
  control.on_progress = [&](const core::Progress& p) { cancel = p.cost.has_value(); };
  PlanResult result;
  EXPECT_EQ(plan(problem, options, control, result), Status::Cancelled);
  EXPECT_TRUE(result.plan.error.within(problem.goal));
  EXPECT_FALSE(result.plan.segments.empty());
}

}  // namespace
}  // namespace stiction::planning::test
