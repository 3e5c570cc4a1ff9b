#include "stiction/tasks/solve.hpp"

#include <gtest/gtest.h>

#include "stiction/core/invalid_input.hpp"

namespace stiction::tasks {
namespace {

SolveOptions fast(std::uint64_t seed) {
  SolveOptions options;
  options.seed = seed;
  return options;
}

TEST(Solve, FirstSeedThatHolds_IsThePlanOfAnyNumberOfThreads) {
  const Task task = load_task("planar_pushing");
  std::vector<std::uint64_t> seeds;
  std::vector<Eigen::VectorXd> ends;
  for (const int threads : {1, 2}) {
    SolveOptions options = fast(3);
    options.threads = threads;
    long told = 0;
    options.on_try = [&](const SolveTry& ended, bool) { told += ended.seed >= 3; };
    SolveResult result;
    ASSERT_EQ(solve(task, options, {}, result), core::Status::Solved);
    EXPECT_TRUE(result.best.holds() && result.best.accepted && result.best.solved());
    EXPECT_GE(told, std::ssize(result.tries));
    EXPECT_EQ(result.tries.back().seed, result.best.seed);
    for (std::size_t i = 0; i < result.tries.size(); ++i) EXPECT_EQ(result.tries[i].seed, 3 + i) << "in turn, up to the first that holds";
    EXPECT_TRUE(result.best.runs.at(0).error.within(task.problem.goal));
    seeds.push_back(result.best.seed);
    ends.push_back(result.best.result.plan.segments.back().knots.back().u);
  }
  EXPECT_EQ(seeds[0], seeds[1]);
  EXPECT_EQ(ends[0], ends[1]);
}

/// A goal that the planner cannot reach in the time: the best try says why it is none.
TEST(Solve, DeadlineAndCancel_KeepTheBestTry) {
  Task task = load_task("planar_pushing");
  core::RunControl control;
  control.deadline = core::RunControl::Clock::now();
  SolveResult result;
  EXPECT_EQ(solve(task, fast(0), control, result), core::Status::MaxIterations);
  ASSERT_EQ(result.tries.size(), 1u);
  EXPECT_FALSE(result.best.solved());
  std::atomic<bool> cancel{true};
  control.deadline.reset();
  control.cancel = &cancel;
  EXPECT_EQ(solve(task, fast(0), control, result), core::Status::Cancelled);
}

TEST(Solve, BetterTry_IsSolvedAcceptedAndReachesMore) {
  SolveTry none, solved, accepted, held;
  for (SolveTry* t : {&solved, &accepted, &held}) t->result.status = core::Status::Solved;
  accepted.accepted = held.accepted = true;
  held.runs.resize(1);
  held.runs[0].reached = true;
  EXPECT_TRUE(solved.better_than(none) && accepted.better_than(solved) && held.better_than(accepted));
  SolveTry later = held;
  later.seed = 1;
  EXPECT_TRUE(held.better_than(later) && !later.better_than(held));
}

TEST(Solve, Mistakes_AreNamed) {
  const Task task = load_task("planar_pushing");
  SolveResult result;
  for (const auto& spoil :
       std::vector<std::pair<const char*, std::function<void(SolveOptions&)>>>{{"tries", [](SolveOptions& o) { o.tries = 0; }},
                                                                               {"friction", [](SolveOptions& o) { o.friction = {}; }},
                                                                               {"friction", [](SolveOptions& o) { o.friction = {1, -1}; }},
                                                                               {"lost_factor", [](SolveOptions& o) { o.lost_factor = 0; }},
                                                                               {"threads", [](SolveOptions& o) { o.threads = -1; }}}) {
    SolveOptions options;
    spoil.second(options);
    try {
      (void)solve(task, options, {}, result);
      ADD_FAILURE() << "accepted: " << spoil.first;
    } catch (const core::InvalidInput& e) {
      EXPECT_EQ(std::string(e.what()).find(spoil.first), 0u) << e.what();
    }
  }
}

}  // namespace
}  // namespace stiction::tasks
