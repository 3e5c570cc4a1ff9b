#pragma once

#include "stiction/planning/expansion.hpp"
#include "stiction/planning/press_limits.hpp"

namespace stiction::planning {

/// Follows commands from a node with the exact dynamics.
class EdgeSimulator {
 public:
  EdgeSimulator(const world::Model& model, const PlannerOptions& options, const RobotChains& chains, const ObjectSpace& space);

  const dynamics::StepOptions& exact() const { return exact_; }

  /// Exact dynamics from a node towards the command u: sub-steps up to where a contact would slip far at once, or one step as in the thesis.
  bool move(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const;
  /// Sub-steps up to where a contact would slip far at once.
  bool roll_out(const Node& from, const Eigen::VectorXd& u, const dynamics::SubstepLimits& limits, ThreadScratch& scratch, Totals& totals,
                Node& to) const;
  /// The states after the commands of an edge at half its sub-step (n_q × commands), every step from its state alone, as the checker does; fewer columns
  /// where it ended before.
  Eigen::MatrixXd follow_in_half_steps(Eigen::VectorXd q, Eigen::VectorXd u_last, const Eigen::MatrixXd& commands, bool limit_gap,
                                       ThreadScratch& scratch, Totals& totals) const;
  /// Nodes that came to nothing only slow the search down.
  bool moves(const Node& from, const Node& to) const;

 private:
  /// A fragile thing bears it.
  bool spares(std::span<const dynamics::ContactImpulse> contacts) const { return press_.share(contacts, options_.h) <= kMostPress; }

  const world::Model& model_;
  const PlannerOptions& options_;
  const ObjectSpace& space_;
  PressLimits press_;
  dynamics::StepOptions exact_, cold_;
};

/// Stores the sub-steps of an edge in its node.
void set_edge(const std::vector<dynamics::Knot>& knots, const world::Model& model, Node& node);

}  // namespace stiction::planning
