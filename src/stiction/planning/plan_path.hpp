#pragma once

#include "stiction/planning/expansion.hpp"

namespace stiction::planning {

/// Makes a plan of a path of the tree.
class PathWriter {
 public:
  explicit PathWriter(const Setting& setting) : setting_(setting) {}

  /// Without what follows the last motion of an object.
  /// @param forces  with those of every sub-step, which take a step each
  Plan to_plan(const Tree& tree, const std::vector<int>& path, bool forces, ThreadScratch& scratch, Totals& totals) const;

 private:
  Plan empty_plan(const Tree& tree) const;
  /// States along an edge, and the forces of every sub-step: the tree keeps no forces.
  Segment describe_edge(const Tree& tree, const Node& node, bool forces, ThreadScratch& scratch, Totals& totals) const;
  /// 3.4.5 (ii): what follows the last motion of the object is dropped.
  void cut_motionless_tail(Plan& plan) const;

  const Setting& setting_;
};

/// Of the path from the root [s].
double cost_to(const world::Model& model, const Node& parent, const Node& node);

}  // namespace stiction::planning
