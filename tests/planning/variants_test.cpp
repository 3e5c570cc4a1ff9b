#include <atomic>
#include <limits>

#include "planning/systems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/tree.hpp"
#include "stiction/world/object_space.hpp"
#include "support/message_of.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr Scheme kSchemes[] = {Scheme::Exact, Scheme::Analytic, Scheme::RandomizedFirst, Scheme::RandomizedZeroth};

PlannerOptions scheme_options(Scheme scheme) {
  PlannerOptions options = hand_options();
  options.scheme = scheme;
  options.randomized.samples = 20;
  options.record_tree = true;
  return options;
}

TEST(Schemes, SameSeed_SameTreeForAnyNumberOfThreads) {
  const PlanningProblem problem = hand_problem();
  for (const Scheme scheme : kSchemes) {
    PlannerOptions options = scheme_options(scheme);
    options.stop_at_goal = false;
    options.max_iterations = 120;
    PlanResult results[3];
    for (int i = 0; i < 3; ++i) {
      options.threads = i == 0 ? 1 : 3;
      options.seed = i == 2 ? 8 : 7;
      ASSERT_EQ(plan(problem, options, {}, results[i]), Status::MaxIterations);
    }
    ASSERT_EQ(results[0].records.size(), results[1].records.size());
    for (std::size_t i = 0; i < results[0].records.size(); ++i) {
      EXPECT_EQ(results[0].records[i].q, results[1].records[i].q);
      EXPECT_EQ(results[0].records[i].B_u, results[1].records[i].B_u);
    }
    EXPECT_NE(results[0].records.back().q, results[2].records.back().q);
    const bool sampled = scheme == Scheme::RandomizedFirst || scheme == Scheme::RandomizedZeroth;
    EXPECT_EQ(results[0].records[0].B_u != results[2].records[0].B_u, sampled) << "only samples follow the seed";
  }
}

TEST(Schemes, OnlyTheExactOneSeesNothingBeforeContact) {
  const PlanningProblem problem = hand_problem();  // 14 mm between arms and ball
  for (const Scheme scheme : kSchemes) {
    PlannerOptions options = scheme_options(scheme);
    options.max_iterations = 1;
    PlanResult result;
    (void)plan(problem, options, {}, result);
    const double seen = result.records.at(0).B_u.norm();
    if (scheme == Scheme::Exact) {
      EXPECT_LT(seen, 1e-5) << "a row with room, to the complementarity that steps with B are centred to";
    } else {
      EXPECT_GT(seen, 0.01);
    }
  }
}

TEST(Schemes, AllReachTheGoal) {
  const PlanningProblem problem = hand_problem();
  for (const Scheme scheme : {Scheme::Analytic, Scheme::RandomizedFirst, Scheme::RandomizedZeroth}) {
    PlannerOptions options = scheme_options(scheme);
    options.max_iterations = 5000;
    PlanResult result;
    EXPECT_EQ(plan(problem, options, {}, result), Status::Solved);
    EXPECT_TRUE(result.plan.error.within(problem.goal));
  }
}

TEST(Schemes, BadSettings_NameTheField) {
  PlannerOptions options = scheme_options(Scheme::RandomizedZeroth);
  PlanResult result;
  const auto message = [&] { return stiction::test::message_of([&] { (void)plan(hand_problem(), options, {}, result); }); };
  options.randomized.samples = 3;
  EXPECT_EQ(message(), "samples: got 3, expected at least 4, one per unknown");
  options.randomized.samples = 20;
  options.randomized.std_u = Eigen::Vector2d(0.1, 0.1);
  EXPECT_EQ(message(), "std_u: got 2 numbers, expected 4");
  options = hand_options();
  options.metric = GlobalMetric{.position = -1};
  EXPECT_EQ(message(), "planner.metric.global.position: got -1, expected a finite number > 0");
}

TEST(GlobalMetric, NearestIsByWeightedSquares) {
  const auto model = load_model("planar_hand");
  const world::ObjectSpace space(*model);
  const Eigen::Vector3d w(10, 10, 1);
  Tree global(space, w), local(space);
  const auto node = [&](const Eigen::Vector3d& q_u, double reach) {
    Node out;
    out.q = Eigen::VectorXd::Zero(7);
    out.q.head<3>() = q_u;
    out.local.set(out.q, reach * Eigen::MatrixXd::Identity(7, 4), 3, Eigen::Vector3d::Constant(1e-6));
    return out;
  };
  const Eigen::VectorXd goal = Eigen::Vector3d::Zero();
  for (Tree* tree : {&global, &local}) {
    tree->add(node({0.1, 0, 0}, 1), goal);      // 0.1 by the weights
    tree->add(node({0, 0, 0.25}, 0.01), goal);  // 0.0625, but hard to move
  }
  EXPECT_EQ(global.nearest(goal), 1);
  EXPECT_EQ(local.nearest(goal), 0);
}

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
  options.max_iterations = 4000;
  double shown = std::numeric_limits<double>::infinity();
  core::RunControl control;
  control.on_progress = [&](const core::Progress& p) {
    if (!p.cost) return;
    EXPECT_LE(*p.cost, shown);
    shown = *p.cost;
  };
  ASSERT_EQ(plan(problem, options, control, result), Status::Solved);
  EXPECT_EQ(result.iterations, 4000);
  ASSERT_GE(result.improvements.size(), 2U) << "nothing to say";
  EXPECT_EQ(result.improvements.front().cost, once.cost);
  for (std::size_t i = 1; i < result.improvements.size(); ++i) EXPECT_LT(result.improvements[i].cost, result.improvements[i - 1].cost);
  EXPECT_EQ(result.cost, result.improvements.back().cost);
  EXPECT_NEAR(result.cost, path_cost(*problem.model, result.plan, options.cost), 1e-12);
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
