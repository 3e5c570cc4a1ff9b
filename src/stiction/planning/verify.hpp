#pragma once

#include "stiction/dynamics/disturbances.hpp"
#include "stiction/planning/expansion.hpp"
#include "stiction/planning/simulate.hpp"

namespace stiction::planning {

/// Tests that an edge must pass before other edges are built on it (docs/theory/verification.md).
class EdgeVerifier {
 public:
  /// @param seed  of the tree. Two trees test different errors of objects, else an unlucky draw could leave a search without a plan.
  EdgeVerifier(const Setting& setting, std::uint64_t seed);

  /// Computes Node::replay of a node whose parent has one, when the node is first built on.
  /// @returns false: the two resolutions disagree, so that the plan would fail its check (an object is about to tip, or a finger to slip);
  ///          or, with margins, a disturbed path goes elsewhere
  bool verify_edge(const Node& parent, const EdgeReplay& parent_replay, const Node& node, ThreadScratch& scratch, Totals& totals,
                   EdgeReplay& replay) const;
  /// Computes the replay of a root that settles from the given start. @returns false: a half step is not solved
  bool verify_root(const Node& root, ThreadScratch& scratch, Totals& totals, EdgeReplay& replay) const;

 private:
  /// Replays an edge with tilted gravity (kEdgeTilt), less friction, and objects off by up to kStartNoise tolerances where a push starts
  /// (two draws of errors, both ways, the same in all n-th pushes). True if objects stay within the tolerances of their states in the tree.
  bool holds_disturbed(const Node& node, const Node& parent, const EdgeReplay& parent_replay, ThreadScratch& scratch, Totals& totals,
                       Eigen::MatrixXd& disturbed) const;
  void move_objects(const Node& parent, int draw, Eigen::VectorXd& q) const;

  const Setting& setting_;
  const std::uint64_t seed_;
  std::vector<Eigen::VectorXd> friction_;  ///< factors of μ for each disturbance (pairs)
};

/// True if a push begins with this edge, because the edge before it is no push.
bool starts_push(const Node& parent, const Node& node);

}  // namespace stiction::planning
