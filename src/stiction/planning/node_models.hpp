#pragma once

#include "stiction/planning/expansion.hpp"

namespace stiction::planning {

/// Smoothed local models of nodes (3.3), c_u and B_u around the command that a node's extensions start from.
class NodeModels {
 public:
  explicit NodeModels(const Setting& setting);

  /// Local model of a node by analytic smoothing (2.27).
  /// @param with_forces  leaves the forces and their derivatives in the scratch's step result as well
  bool linearise(Node& node, bool with_forces, ThreadScratch& scratch, Totals& totals) const;
  /// Where the command of an extension starts from: the joints, and what is left of the grip (P.11).
  Eigen::VectorXd preloaded_command(const Node& node) const;

 private:
  /// Far from the goal a smooth model sees far; near it the force at a distance would hide the last millimetres.
  dynamics::Analytic smoothing_at(const Node& node) const;

  const Setting& setting_;
  Eigen::VectorXd gamma_;  // diagonal of Γ (P.1)
  dynamics::StepOptions smoothed_;
};

}  // namespace stiction::planning
