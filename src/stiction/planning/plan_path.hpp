#pragma once

#include "stiction/planning/expansion.hpp"

namespace stiction::planning {

/// Converts a path of the tree into a plan.
class PathWriter {
 public:
  explicit PathWriter(const Setting& setting) : setting_(setting) {}

  /// The plan of a path, without the commands after the last motion of an object.
  /// @param forces  add the contact forces of every sub-step, at the cost of one step each
  Plan to_plan(const Tree& tree, const std::vector<int>& path, bool forces, ThreadScratch& scratch, Totals& totals) const;

 private:
  Plan empty_plan(const Tree& tree) const;
  /// States along an edge and, if asked for, the contact forces of every sub-step: the tree keeps no forces.
  Segment describe_edge(const Tree& tree, const Node& node, bool forces, ThreadScratch& scratch, Totals& totals) const;
  /// 3.4.5 (ii): drops the commands after the last motion of the object.
  void cut_motionless_tail(Plan& plan) const;

  const Setting& setting_;
};

/// Cost of the path from the root to a node [s].
double cost_to(const world::Model& model, const Node& parent, const Node& node);

}  // namespace stiction::planning
