#include "stiction/planning/planner.hpp"

#include <map>

#include "planning/systems.hpp"
#include "stiction/planning/thresholds.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

struct Told {
  std::vector<int> parents;
  std::vector<Eigen::VectorXd> q, u;
  int best = -1;
  double best_ratio = 0;
};

/// What was told of every tree, put together.
core::Status watch(const PlanningProblem& problem, const PlannerOptions& options, PlanResult& result, std::map<int, Told>& trees) {
  const auto grown = [&trees](const Growth& growth) {
    Told& told = trees[growth.tree];
    ASSERT_EQ(growth.first, std::ssize(told.parents)) << "none is left out, none is told twice";
    ASSERT_EQ(growth.q.cols(), std::ssize(growth.parents));
    told.parents.insert(told.parents.end(), growth.parents.begin(), growth.parents.end());
    for (const auto& q : growth.q.colwise()) told.q.emplace_back(q);
    for (const auto& u : growth.u.colwise()) told.u.emplace_back(u);
    told.best = growth.best;
    told.best_ratio = growth.best_ratio;
  };
  return plan_watched(problem, {}, options, {}, grown, result);
}

TEST(Growth, EveryNodeOfTheTreeIsToldOnce_AndThePlanIsTheSame) {
  const PlanningProblem problem = hand_problem();
  for (const std::uint64_t seed : {0U, 1U}) {
    PlannerOptions options = hand_options();
    options.seed = seed;
    options.max_iterations = 20000;
    PlanResult alone, watched;
    std::map<int, Told> told;
    ASSERT_EQ(plan(problem, options, {}, alone), Status::Solved);
    ASSERT_EQ(watch(problem, options, watched, told), Status::Solved);
    EXPECT_EQ(watched.iterations, alone.iterations);
    ASSERT_EQ(watched.tree.size(), alone.tree.size());
    ASSERT_EQ(watched.plan.segments.size(), alone.plan.segments.size());
    for (std::size_t s = 0; s < alone.plan.segments.size(); ++s) {
      ASSERT_EQ(watched.plan.segments[s].knots.size(), alone.plan.segments[s].knots.size());
      EXPECT_TRUE(watched.plan.segments[s].knots.back().q == alone.plan.segments[s].knots.back().q);
    }
    const auto same = [&](const auto& entry) {
      const Told& tree = entry.second;
      bool equal = tree.parents.size() == watched.tree.size();
      for (std::size_t i = 0; equal && i < tree.parents.size(); ++i) {
        const world::Pose X = world::object_pose(*problem.model, tree.q[i], problem.goal.object);
        equal = tree.parents[i] == watched.tree[i].parent && X.p == watched.tree[i].X_WB.p;
      }
      return equal;
    };
    const auto at = std::find_if(told.begin(), told.end(), same);
    ASSERT_NE(at, told.end()) << "the tree of the plan";
    EXPECT_LE(at->second.best_ratio, 1);
    EXPECT_TRUE(at->second.q[static_cast<std::size_t>(at->second.best)] == watched.plan.segments.back().knots.back().q);
    EXPECT_TRUE(at->second.u[static_cast<std::size_t>(at->second.best)] == watched.plan.segments.back().knots.back().u);
  }
}

TEST(Growth, Root_HasNoParentAndIsTheStart) {
  const PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.max_iterations = threshold::kBatch;
  options.tolerance_fraction = 1e-3;
  PlanResult result;
  std::map<int, Told> told;
  ASSERT_EQ(watch(problem, options, result, told), Status::MaxIterations);
  ASSERT_FALSE(told.empty());
  const Told& first = told.begin()->second;
  EXPECT_EQ(first.parents.front(), -1);
  EXPECT_TRUE(first.q.front().isApprox(problem.q_start, 1e-6));
  for (std::size_t i = 1; i < first.parents.size(); ++i) EXPECT_LT(first.parents[i], static_cast<int>(i));
}

}  // namespace
}  // namespace stiction::planning::test
