#pragma once

#include "stiction/planning/extend.hpp"

namespace stiction::planning {

/// A regrasp as an edge of the tree (3.4.3): which branches let go, and where they grasp anew.
class ContactChange {
 public:
  ContactChange(const Setting& setting, const NodeModels& models, const Extend& extend)
      : setting_(setting), models_(models), extend_(extend) {}

  /// Chooses the node where a regrasp starts, and the branches that let go. After a regrasp, a second one would only undo the first (3.4.5
  /// (i)), so it starts where the first one started. Branches whose release leaves the objects stable are preferred.
  void choose(const Tree& tree, Expansion& x, core::Random& random) const;
  bool try_edge(const Tree& tree, Expansion& x, core::Random& random, ThreadScratch& scratch, Node& node) const;

 private:
  /// Distance of the objects from the subgoal, in tolerances of the goal, that the local model at q predicts after the extension (P.2).
  Promise predict(const Eigen::VectorXd& q, const Eigen::VectorXd& u, Expansion& x, ThreadScratch& scratch) const;
  /// The same distance after the extension is simulated with the exact dynamics.
  double simulated_distance(const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Eigen::VectorXd& command, const Expansion& x,
                            ThreadScratch& scratch) const;

  const Setting& setting_;
  const NodeModels& models_;
  const Extend& extend_;
};

}  // namespace stiction::planning
