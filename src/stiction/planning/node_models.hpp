#pragma once

#include "stiction/planning/expansion.hpp"

namespace stiction::planning {

/// Smoothed local models of nodes (3.3), c_u and B_u around the command that a node's extensions start from.
class NodeModels {
 public:
  explicit NodeModels(const Setting& setting);

  /// Local model of a node. @param stream  of the samples of a randomised scheme
  bool linearise(Node& node, std::uint64_t stream, ThreadScratch& scratch, Totals& totals) const;
  /// The same by the analytic scheme; leaves the forces and their derivatives in the scratch's step result.
  bool linearise_with_forces(Node& node, ThreadScratch& scratch, Totals& totals) const;
  /// Where the command of an extension starts from: the joints, and what is left of the grip (P.11).
  Eigen::VectorXd preloaded_command(const Node& node) const;

 private:
  /// Far from the goal a smooth model sees far; near it the force at a distance would hide the last millimetres.
  dynamics::LocalModelScheme scheme_at(const Node& node, std::uint64_t stream) const;
  bool take_model(core::Status status, const Eigen::VectorXd& q_next, const Eigen::MatrixXd& B, Node& node, Totals& totals) const;

  const Setting& setting_;
  Eigen::VectorXd joint_units_, gamma_;  // D and the diagonal of Γ (P.1)
  dynamics::StepOptions smoothed_;
};

}  // namespace stiction::planning
