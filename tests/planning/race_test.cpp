#include "stiction/planning/race.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "stiction/core/random.hpp"

namespace stiction::planning {
namespace {

/// Grows what is next, all trees with distances of their own, and says which and how far.
std::string grow(Race& race, const std::vector<double>& distances, int times) {
  std::string out;
  for (int k = 0; k < times; ++k) {
    const int tree = race.next();
    out += std::to_string(tree) + ":" + std::to_string(race.budget(tree)) + " ";
    race.reached(tree, distances[static_cast<std::size_t>(tree)], false);
  }
  return out;
}

TEST(Race, BetterHalfOfARungGoesOn) {
  Race race(10);
  EXPECT_EQ(grow(race, {3, 1, 4, 2}, 7), "0:10 1:10 1:20 2:10 3:10 3:20 1:40 ")
      << "of two the nearer, of four the two nearest, of those two one";
}

TEST(Race, LateTreeThatIsNearerOvertakes) {
  Race race(10);
  EXPECT_EQ(grow(race, {3, 2, 1, 9}, 6), "0:10 1:10 1:20 2:10 2:20 2:40 ") << "1 had gone on already when 2 came";
}

TEST(Race, StalledTreeStaysWhereItIs) {
  Race race(10);
  const int first = race.next();
  race.reached(first, 2, false);
  const int second = race.next();
  race.reached(second, 1, true);
  EXPECT_EQ(race.next(), 2) << "1 is the better half";
}

TEST(Race, TwoTreesUnderWay) {
  Race race(10);
  EXPECT_EQ(race.next(), 0);
  EXPECT_EQ(race.next(), 1);
  race.reached(1, 2, false);
  EXPECT_EQ(race.next(), 2) << "0 has not come to its rung yet";
  race.reached(0, 1, false);
  EXPECT_EQ(race.next(), 0);
  EXPECT_EQ(race.budget(0), 20);
  EXPECT_EQ(race.next(), 3) << "0 is on its way, and the better half of two is one";
}

TEST(Race, EqualDistances_FirstComeFirst) {
  Race race(1);
  EXPECT_EQ(grow(race, {5, 5, 5, 5}, 7), "0:1 1:1 0:2 2:1 3:1 1:2 0:4 ");
}

/// Trees of which one in ten ends at the goal after a hundred steps, and can be told from the others after ten: what restarts of a hundred need
/// 1000 steps for in the mean, when somebody knows the hundred, costs about half.
TEST(Race, GoodTreesThatShowEarly_CostLessThanTheBestRestarts) {
  constexpr int kRuns = 400, kGoal = 100;
  double raced = 0, restarted = 0;
  for (int run = 0; run < kRuns; ++run) {
    core::Random random(1, static_cast<std::uint64_t>(run));
    std::vector<bool> good;
    std::vector<long> grown;
    Race race(10);
    for (bool done = false; !done;) {
      const auto tree = static_cast<std::size_t>(race.next());
      if (tree == good.size()) {
        good.push_back(random.chance(0.1));
        grown.push_back(0);
      }
      const long to = race.budget(static_cast<int>(tree));
      done = good[tree] && to >= kGoal;
      raced += static_cast<double>((done ? kGoal : to) - grown[tree]);
      grown[tree] = to;
      race.reached(static_cast<int>(tree), good[tree] ? 0 : random.uniform(0.5, 1), false);
    }
    do restarted += kGoal;
    while (!random.chance(0.1));
  }
  EXPECT_NEAR(restarted / kRuns, 1000, 150);
  EXPECT_LT(raced, 0.65 * restarted);
}

}  // namespace
}  // namespace stiction::planning
