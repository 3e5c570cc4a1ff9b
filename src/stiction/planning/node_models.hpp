#pragma once

#include "stiction/planning/expansion.hpp"

namespace stiction::planning {

/// Computes the smoothed local models of nodes (3.3): c_u and B_u around the command from which a node's extensions start.
class NodeModels {
 public:
  explicit NodeModels(const Setting& setting);

  /// Computes the local model of a node by analytic smoothing (2.27).
  /// @param with_forces  leaves contact forces and their derivatives in the step result of the scratch as well
  bool linearise(Node& node, bool with_forces, ThreadScratch& scratch, Totals& totals) const;
  /// Command from which an extension starts: the joint positions, and the preload that is left of the grip (P.11).
  Eigen::VectorXd preloaded_command(const Node& node) const;

 private:
  /// κ is small far from the goal, so that the model sees far. κ grows near it: a force at a distance would hide the last millimetres.
  dynamics::Analytic smoothing_at(const Node& node) const;

  const Setting& setting_;
  Eigen::VectorXd gamma_;  // diagonal of Γ (P.1)
  dynamics::StepOptions smoothed_;
};

}  // namespace stiction::planning
