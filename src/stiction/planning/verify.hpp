#pragma once

#include "stiction/dynamics/disturbances.hpp"
#include "stiction/planning/expansion.hpp"
#include "stiction/planning/simulate.hpp"

namespace stiction::planning {

/// What an edge has to stand before others are built on it (docs/theory/verification.md).
class EdgeVerifier {
 public:
  /// @param seed  of the tree: two trees do not stand the same errors of objects, else a search with unlucky ones would find no plan
  EdgeVerifier(const Setting& setting, std::uint64_t seed);

  /// Computes Node::replay of a node whose parent has it. False where the two resolutions disagree: an object about to tip or a finger about to slip off
  /// would not survive the check of the plan; and, with margins, where a disturbed path goes elsewhere. Done once, when the node is first built on.
  bool verify_edge(const Node& parent, const EdgeReplay& parent_replay, const Node& node, ThreadScratch& scratch, Totals& totals,
                   EdgeReplay& replay) const;
  /// The replay of a root that settles from the given start. @returns false where a half step is not solved
  bool verify_root(const Node& root, ThreadScratch& scratch, Totals& totals, EdgeReplay& replay) const;

 private:
  /// The objects off by up to kStartNoise of the tolerances wherever a push starts, by two draws of errors either way, the same in all n-th pushes; gravity
  /// kEdgeTilt aside; less friction: after every edge they still are within the tolerances of where the tree has them.
  bool holds_disturbed(const Node& node, const Node& parent, const EdgeReplay& parent_replay, ThreadScratch& scratch, Totals& totals,
                       Eigen::MatrixXd& disturbed) const;
  void move_objects(const Node& parent, int draw, Eigen::VectorXd& q) const;

  const Setting& setting_;
  const std::uint64_t seed_;
  std::vector<Eigen::VectorXd> friction_;  ///< of each disturbance: factors of μ (pairs)
};

/// A push begins with this edge: the one before it is none.
bool starts_push(const Node& parent, const Node& node);

}  // namespace stiction::planning
