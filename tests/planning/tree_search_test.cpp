#include "stiction/planning/tree_search.hpp"

#include "planning/systems.hpp"

namespace stiction::planning::test {
namespace {

/// Places of the objects and joints in the first nodes of a tree.
std::vector<Eigen::VectorXd> grow(const PlanningProblem& problem, std::uint64_t seed_of_run, std::uint64_t seed_of_tree) {
  PlannerOptions options = hand_options();
  options.margins = true;
  options.seed = seed_of_run;
  const Setting setting(problem, options);
  const core::RunControl control;
  const Eigen::VectorXd u_start;
  ThreadScratch scratch(problem.model, control);
  TreeSearch search(setting, u_start, seed_of_tree, std::numeric_limits<double>::infinity());
  PlanResult result;
  EXPECT_TRUE(search.plant_root(scratch, result)) << result.reason;
  for (int k = 0; k < 60; ++k) {
    Expansion x = search.draw();
    search.expand(x, scratch);
    search.insert(x, scratch);
  }
  std::vector<Eigen::VectorXd> out;
  for (int i = 0; i < search.tree().size(); ++i) out.push_back(search.tree()[i].q);
  return out;
}

/// Also of the errors that its plan has to stand: where all trees of a run share them, a run with unlucky ones finds no plan, however many trees it plants.
TEST(TreeSearch, EverythingDrawn_FollowsFromTheSeedOfTheTree) {
  const PlanningProblem problem = hand_problem();
  const auto tree = grow(problem, 1, 5), in_another_run = grow(problem, 2, 5), another = grow(problem, 1, 6);
  EXPECT_GT(tree.size(), 20U);
  EXPECT_EQ(tree, in_another_run);
  EXPECT_NE(tree, another);
}

/// The longer a tree waits for progress, the more of its regrasps start where the objects are nearest to a drawn place.
TEST(TreeSearch, TreeThatComesNoNearer_Explores) {
  const PlanningProblem problem = hand_problem();
  const PlannerOptions options = hand_options();
  const Setting setting(problem, options);
  const core::RunControl control;
  const Eigen::VectorXd u_start;
  ThreadScratch scratch(problem.model, control);
  TreeSearch search(setting, u_start, 5, std::numeric_limits<double>::infinity());
  PlanResult result;
  ASSERT_TRUE(search.plant_root(scratch, result)) << result.reason;
  const auto count_exploring = [&](int draws) {
    int exploring = 0;
    for (int k = 0; k < draws; ++k) {
      Expansion x = search.draw();
      exploring += x.at_place;
      EXPECT_TRUE(!x.at_place || (x.grasp && !x.to_goal && x.near < 0));
      x = {};
      x.near = 0;
      search.insert(x, scratch);  // which came to nothing
    }
    return exploring;
  };
  const int early = count_exploring(300);
  count_exploring(400);
  const int late = count_exploring(300);
  EXPECT_GT(late, 2 * early) << early;
  EXPECT_FALSE(search.stalled());
  count_exploring(2);
  EXPECT_TRUE(search.stalled());
}

}  // namespace
}  // namespace stiction::planning::test
