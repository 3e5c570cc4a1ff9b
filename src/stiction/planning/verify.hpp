#pragma once

#include <array>

#include "stiction/dynamics/disturbances.hpp"
#include "stiction/planning/edge_simulator.hpp"

namespace stiction::planning {

/// No edge of a path: it got where it was to go.
constexpr int kOnPath = -1;

/// What an edge has to stand before others are built on it (docs/theory/verification.md).
class EdgeVerifier {
 public:
  EdgeVerifier(const Setting& setting, const EdgeSimulator& simulator);

  /// Computes Node::replay of a node whose parent has it. False where the two resolutions disagree: an object about to tip or a
  /// finger about to slip off would not survive the check of the plan; and where a disturbed path goes elsewhere. Done once, when the node is first built on.
  /// @param left  of an edge that the resolutions disagree on, what comes before; no q where that is nothing
  bool verify_edge(const Node& parent, const EdgeReplay& parent_replay, const Node& node, ThreadScratch& scratch, Totals& totals,
                   EdgeReplay& replay, Node* left = nullptr) const;
  /// Something is to be disturbed.
  bool disturbs() const;
  /// @returns kOnPath: the goal was reached; else the first edge that went elsewhere, or the last one
  int follow_with_noise(const Tree& tree, const std::vector<int>& path, ThreadScratch& scratch, Totals& totals) const;

 private:
  /// The first n sub-steps of an edge. False where they move nothing.
  bool cut_edge(const Node& parent, const Node& node, Eigen::Index n, Eigen::VectorXd q_fine, Node& out) const;
  /// The objects off by up to start_noise of the tolerances wherever a push starts, by two draws of errors either way, the same in all n-th pushes; gravity
  /// edge_tilt aside; less friction: after every edge they still are within the tolerances of where the tree has them. Pushes that multiply errors, and those
  /// that hold an object by less than that, are left before others are built on them.
  bool holds_disturbed(const Node& node, const Node& parent, const EdgeReplay& parent_replay, ThreadScratch& scratch, Totals& totals,
                       Eigen::MatrixXd& disturbed) const;
  /// Disturbed paths in the order in which they are likely to go elsewhere.
  std::array<Eigen::Index, dynamics::kDisturbances> farthest_first(const Node& node, const Eigen::MatrixXd& disturbed) const;

  const Setting& setting_;
  const EdgeSimulator& simulator_;
  std::vector<Eigen::VectorXd> friction_;  ///< of each disturbance: factors of μ (pairs)
};

/// A push begins with this edge: the one before it is none.
bool starts_push(const Node& parent, const Node& node);

}  // namespace stiction::planning
