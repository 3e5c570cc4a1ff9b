#include "stiction/planning/front.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace stiction::planning {
namespace {

struct Nodes {
  std::map<int, double> distance;
  Front front;
  int removed = -1;

  void add(int node, int cell, double d) {
    distance[node] = d;
    front.add(node, cell, d);
  }
  int take() {
    return front.take([this](int i) { return i != removed; }, [this](int i) { return distance.at(i); });
  }
  /// How often each of n nodes comes in so many choices.
  std::vector<int> choices(int n, int times) {
    std::vector<int> out(static_cast<std::size_t>(n), 0);
    for (int k = 0; k < times; ++k) ++out[static_cast<std::size_t>(take())];
    return out;
  }
};

TEST(Front, OfNodesThatAreEquallyWorn_TheNearestComesFirst) {
  Nodes nodes;
  nodes.add(0, 0, 5);
  nodes.add(1, 1, 2);
  nodes.add(2, 2, 9);
  EXPECT_EQ(nodes.take(), 1);
  EXPECT_EQ(Nodes().take(), -1);
}

TEST(Front, EachInACellOfItsOwn_ComesByDistanceAndWear) {
  Nodes nodes;
  for (int i = 0; i < 4; ++i) nodes.add(i, i, i);
  const std::vector<int> times = nodes.choices(4, 4000);
  EXPECT_TRUE(std::is_sorted(times.rbegin(), times.rend()));
  // (1 + d)(1 + n/5)(1 + c/(5 c̄)) is the same for all in the end, with n = c and c̄ = 1000
  for (int i = 1; i < 4; ++i) {
    const auto cost = [&](int k) {
      return (1 + k) * (1 + 0.2 * times[static_cast<std::size_t>(k)]) * (1 + 0.2e-3 * times[static_cast<std::size_t>(k)]);
    };
    EXPECT_NEAR(cost(i) / cost(0), 1, 0.02) << i;
  }
}

TEST(Front, CrowdInOneCell_LeavesTurnsToOthers) {
  constexpr int kCrowd = 100;
  const auto turns_of_the_other = [](bool one_cell) {
    Nodes nodes;
    for (int i = 0; i < kCrowd; ++i) nodes.add(i, one_cell ? 0 : i + 1, 2);
    for (int i = 0; i < 50; ++i) nodes.add(kCrowd + i, kCrowd + 1 + i, i == 0 ? 3 : 1000);
    return nodes.choices(kCrowd + 50, 300)[kCrowd];
  };
  EXPECT_GT(turns_of_the_other(true), 4 * turns_of_the_other(false));
}

TEST(Front, WhatIsNotUsable_IsGone) {
  Nodes nodes;
  nodes.add(0, 0, 1);
  nodes.add(1, 0, 2);
  nodes.removed = 0;
  EXPECT_EQ(nodes.take(), 1);
  nodes.removed = -1;
  for (int k = 0; k < 50; ++k) EXPECT_EQ(nodes.take(), 1);
}

TEST(Front, NodeThatIsFartherThanItSeemed_ComesBackWithWhatItIs) {
  Nodes nodes;
  nodes.add(0, 0, 1);
  nodes.add(1, 1, 5);
  nodes.distance[0] = 1000;
  EXPECT_EQ(nodes.take(), 1);
}

}  // namespace
}  // namespace stiction::planning
