#pragma once

#include <Eigen/Core>
#include <functional>
#include <queue>
#include <vector>

#include "stiction/planning/nearest.hpp"

namespace stiction::planning {

/// The order in which nodes are extended towards the goal (P.12).
///
/// A node costs (1 + d)(1 + kVisit n)(1 + kVisit c/c̄): d is its distance from the goal by the measure of Tree, n counts its visits, c
/// counts the visits of its cell, and c̄ is the mean over cells. Nodes whose objects are at one place share a cell. Where a search is
/// stuck, it makes new nodes beside the old ones as fast as it visits these; the visits of the cell then make all of them expensive.
/// Tests: tests/planning/frontier_test.cpp
class Frontier {
 public:
  /// @param weights  w of the distance Σ wᵢ eᵢ² between objects, in tolerances (n_v)
  Frontier(const world::ObjectSpace& space, Eigen::VectorXd weights) : cells_(space), weights_(std::move(weights)) {}

  /// Adds the next node. @param q_u  its objects (n_q)  @param distance  d  @param visited  the node was extended already
  void add(const Eigen::VectorXd& q_u, double distance, bool visited);

  /// Takes the cheapest usable node and counts a visit; −1 if there is none. A node that is not usable never comes back.
  /// @param distance  present distance of a node from the goal
  int take(const std::function<bool(int)>& usable, const std::function<double(int)>& distance);

 private:
  struct Choice {
    double cost;
    int node;
    bool operator>(const Choice& o) const { return cost != o.cost ? cost > o.cost : node > o.node; }
  };

  double cost(int node, double distance) const;
  int cell_of(const Eigen::VectorXd& q_u, double distance);
  void visit(int node);

  std::priority_queue<Choice, std::vector<Choice>, std::greater<>> queue_;  // costs may be out of date
  std::vector<int> cell_, visits_;                                          // by node
  std::vector<int> cell_visits_;                                            // by cell
  long all_visits_ = 0;
  NearestPoints cells_;
  Eigen::VectorXd weights_;
};

}  // namespace stiction::planning
