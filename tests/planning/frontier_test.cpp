#include "stiction/planning/frontier.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "planning/systems.hpp"

namespace stiction::planning {
namespace {

/// Nodes of planar_pushing, whose objects are at places of their own unless they are said to share one.
struct Nodes {
  std::shared_ptr<const world::Model> model = test::load_model("planar_pushing");
  world::ObjectSpace space{*model};
  std::map<int, double> distance;
  Frontier frontier{space, Eigen::Vector3d::Ones()};
  int removed = -1;

  /// @param place  far from every other one
  void add(int node, int place, double d) {
    distance[node] = d;
    frontier.add(Eigen::Vector3d(1e6 * place, 0, 0), d, false);
  }
  int take() {
    return frontier.take([this](int i) { return i != removed; }, [this](int i) { return distance.at(i); });
  }
  /// How often each of n nodes comes in so many choices.
  std::vector<int> choices(int n, int times) {
    std::vector<int> out(static_cast<std::size_t>(n), 0);
    for (int k = 0; k < times; ++k) ++out[static_cast<std::size_t>(take())];
    return out;
  }
};

TEST(Frontier, OfNodesThatAreEquallyVisited_TheNearestComesFirst) {
  Nodes nodes;
  nodes.add(0, 0, 5);
  nodes.add(1, 1, 2);
  nodes.add(2, 2, 9);
  EXPECT_EQ(nodes.take(), 1);
  EXPECT_EQ(Nodes().take(), -1);
}

TEST(Frontier, EachInACellOfItsOwn_NearerOnesComeMoreOftenAndAllGetTheirTurn) {
  Nodes nodes;
  for (int i = 0; i < 4; ++i) nodes.add(i, i, i);
  const std::vector<int> times = nodes.choices(4, 4000);
  EXPECT_TRUE(std::is_sorted(times.rbegin(), times.rend()));
  EXPECT_GT(times[3], 0);
  EXPECT_GT(times[0], 1.3 * times[3]);
}

TEST(Frontier, CrowdInOneCell_LeavesTurnsToOthers) {
  constexpr int kCrowd = 100;
  const auto turns_of_the_other = [](bool one_cell) {
    Nodes nodes;
    for (int i = 0; i < kCrowd; ++i) nodes.add(i, one_cell ? 0 : i + 1, 2);
    for (int i = 0; i < 50; ++i) nodes.add(kCrowd + i, kCrowd + 1 + i, i == 0 ? 3 : 1000);
    return nodes.choices(kCrowd + 50, 300)[kCrowd];
  };
  EXPECT_GT(turns_of_the_other(true), 4 * turns_of_the_other(false));
}

TEST(Frontier, NodeThatIsGone_NeverComesAgain) {
  Nodes nodes;
  nodes.add(0, 0, 1);
  nodes.add(1, 0, 2);
  nodes.removed = 0;
  EXPECT_EQ(nodes.take(), 1);
  nodes.removed = -1;
  for (int k = 0; k < 50; ++k) EXPECT_EQ(nodes.take(), 1);
}

TEST(Frontier, NodeThatIsFartherThanItSeemed_ComesBackWithWhatItIs) {
  Nodes nodes;
  nodes.add(0, 0, 1);
  nodes.add(1, 1, 5);
  nodes.distance[0] = 1000;
  EXPECT_EQ(nodes.take(), 1);
}

}  // namespace
}  // namespace stiction::planning
