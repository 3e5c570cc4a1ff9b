#pragma once

#include <Eigen/Core>
#include <functional>
#include <queue>
#include <vector>

#include "stiction/planning/nearest.hpp"

namespace stiction::planning {

/// The order in which nodes near the goal are taken to grow from (P.12).
///
/// A node costs (1 + d)(1 + kVisit n)(1 + kVisit c/c̄): d is its distance from the goal in tolerances, n counts the visits of the node, c those of its cell
/// and c̄ the mean over cells. Nodes whose objects are at one place share a cell: where a search is stuck, new nodes come up beside the old ones as fast as
/// these are visited. Of nodes with one cost the metric takes the one that is easiest to bring to the goal.
/// Tests: tests/planning/frontier_test.cpp
class Frontier {
 public:
  /// @param weights  w of the distance Σ wᵢ eᵢ² of objects, in tolerances (n_v)
  Frontier(const world::ObjectSpace& space, Eigen::VectorXd weights) : cells_(space), weights_(std::move(weights)) {}

  /// The next node.
  /// @param q_u       its objects (n_q)  @param distance  from the goal [tolerances]  @param metric  d(q_goal; node) of (3.5)
  /// @param visited   the search extended it already
  void add(const Eigen::VectorXd& q_u, double distance, double metric, bool visited);

  /// The cheapest node that is usable, −1 when there is none. Counts a visit.
  /// @param gone      the node is never usable again
  /// @param usable    … for what it is taken for now
  /// @param distance  of a node from the goal by now
  int take(const std::function<bool(int)>& gone, const std::function<bool(int)>& usable, const std::function<double(int)>& distance);

 private:
  struct Choice {
    double cost, metric;
    int node;
    bool operator>(const Choice& o) const {
      if (cost != o.cost) return cost > o.cost;
      return metric != o.metric ? metric > o.metric : node > o.node;
    }
  };

  double cost(int node, double distance) const;
  int cell_of(const Eigen::VectorXd& q_u, double distance);
  void visit(int node);

  std::priority_queue<Choice, std::vector<Choice>, std::greater<>> queue_;  // costs may be those of an earlier time
  std::vector<int> cell_, visits_;                                          // by node
  std::vector<int> cell_visits_;                                            // by cell
  long all_visits_ = 0;
  NearestPoints cells_;
  Eigen::VectorXd weights_;
};

}  // namespace stiction::planning
