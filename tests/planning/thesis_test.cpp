// Algorithm 2 as printed.

#include "planning/systems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/world/object_space.hpp"
#include "support/message_of.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;
using thesis::Scheme;

constexpr Scheme kSchemes[] = {Scheme::Exact, Scheme::Analytic, Scheme::RandomizedFirst, Scheme::RandomizedZeroth};

PlannerOptions scheme_options(Scheme scheme) {
  PlannerOptions options = hand_options();
  options.goal_bias = 0.1;
  options.thesis.emplace();
  options.thesis->grasp_probability = 0.2;
  options.thesis->scheme = scheme;
  options.thesis->randomized.samples = 20;
  return options;
}

TEST(Thesis, SameSeed_SameTree) {
  const PlanningProblem problem = hand_problem();
  for (const Scheme scheme : kSchemes) {
    PlannerOptions options = scheme_options(scheme);
    options.thesis->stop_at_goal = false;
    options.max_iterations = 120;
    PlanResult results[3];
    for (int i = 0; i < 3; ++i) {
      options.seed = i == 2 ? 8 : 7;
      ASSERT_EQ(plan(problem, options, {}, results[i]), Status::MaxIterations);
      EXPECT_EQ(results[i].iterations, 120);
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

/// Algorithm 3: every extension has its length, and is one exact step; every jump leaves the objects where they are.
TEST(Thesis, Edges_AreSingleStepsOfTheirLengthAndJumps) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = scheme_options(Scheme::Analytic);
  options.thesis->stop_at_goal = false;
  options.max_iterations = 200;
  PlanResult result;
  ASSERT_EQ(plan(problem, options, {}, result), Status::MaxIterations);
  ASSERT_EQ(result.records.size(), result.tree.size());
  int jumps = 0, pushes = 0;
  for (const NodeRecord& node : result.records) {
    if (node.parent < 0) continue;
    const Eigen::VectorXd& from = result.records[static_cast<std::size_t>(node.parent)].q;
    if (node.edge == SegmentKind::Regrasp) {
      EXPECT_EQ(node.q.head(3), from.head(3));
      EXPECT_NE(result.records[static_cast<std::size_t>(node.parent)].edge, SegmentKind::Regrasp);
      ++jumps;
    } else {
      ++pushes;
    }
  }
  EXPECT_GT(jumps, 5);
  EXPECT_GT(pushes, 50);
  for (const Segment& segment : result.plan.segments) EXPECT_EQ(segment.knots.size(), 1U);
}

TEST(Thesis, OnlyTheExactOneSeesNothingBeforeContact) {
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

TEST(Thesis, AllReachTheGoal) {
  const PlanningProblem problem = hand_problem();
  for (const Scheme scheme : {Scheme::Analytic, Scheme::RandomizedFirst, Scheme::RandomizedZeroth}) {
    PlannerOptions options = scheme_options(scheme);
    options.max_iterations = 20000;
    PlanResult result;
    EXPECT_EQ(plan(problem, options, {}, result), Status::Solved);
    EXPECT_TRUE(result.plan.error.within(problem.goal));
  }
}

TEST(Thesis, BadSettings_NameTheField) {
  PlannerOptions options = scheme_options(Scheme::RandomizedZeroth);
  PlanResult result;
  const auto message = [&] { return stiction::test::message_of([&] { (void)plan(hand_problem(), options, {}, result); }); };
  options.thesis->randomized.samples = 3;
  EXPECT_EQ(message(), "samples: got 3, expected at least 4, one per unknown");
  options.thesis->randomized.samples = 20;
  options.thesis->randomized.std_u = Eigen::Vector2d(0.1, 0.1);
  EXPECT_EQ(message(), "std_u: got 2 numbers, expected 4");
  options = scheme_options(Scheme::Analytic);
  options.thesis->metric = thesis::GlobalMetric{.position = -1};
  EXPECT_EQ(message(), "planner.thesis.metric.global.position: got -1, expected a finite number > 0");
}

}  // namespace
}  // namespace stiction::planning::test
