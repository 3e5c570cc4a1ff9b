#pragma once

#include <functional>
#include <queue>
#include <vector>

namespace stiction::planning {

/// A node that may be taken, the cheapest first.
struct Choice {
  double cost;
  int node;
  bool operator>(const Choice& o) const { return cost != o.cost ? cost > o.cost : node > o.node; }
};
using Choices = std::priority_queue<Choice, std::vector<Choice>, std::greater<>>;

/// The order in which nodes near the goal are taken to grow from, for one purpose: pushes or regrasps.
///
/// A node costs 1 + its distance from the goal; each choice wears it, and more so its *cell*, the nodes whose objects are at one place: where a search is
/// stuck, new nodes come up beside the old ones as fast as those wear (P.12).
/// Tests: tests/planning/front_test.cpp
class Front {
 public:
  /// @param cell  number of its cell, from 0 on  @param distance  from the goal [tolerances]
  void add(int node, int cell, double distance);

  /// The cheapest node that is usable, −1 when there is none; one that is not is gone for good. Marks it.
  /// @param distance  of a node from the goal by now
  int take(const std::function<bool(int)>& usable, const std::function<double(int)>& distance);

 private:
  double cost(int node, double distance) const;

  /// Costs may be those of an earlier time: they grow with every choice in the cell.
  Choices queue_;
  std::vector<int> cell_, taken_;  // by node
  std::vector<int> taken_in_;      // by cell
  long choices_ = 0;
};

}  // namespace stiction::planning
