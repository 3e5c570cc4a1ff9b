#pragma once

#include "stiction/planning/expansion.hpp"
#include "stiction/planning/simulate.hpp"

namespace stiction::planning {

/// Tests an edge before other edges are built on it, when its node is first built on (docs/theory/verification.md): computes Node::q_fine of a node whose parent has
/// one.
/// @returns false: the two resolutions disagree, so that the plan would fail its check (an object is about to tip, or a finger to slip)
bool verify_edge(const Setting& setting, const Node& parent, const Eigen::VectorXd& parent_fine, const Node& node, ThreadScratch& scratch,
                 Totals& totals, Eigen::VectorXd& q_fine);
/// Computes Node::q_fine of a root that settles from the given start. @returns false: a half step is not solved
bool verify_root(const Setting& setting, const Node& root, ThreadScratch& scratch, Totals& totals, Eigen::VectorXd& q_fine);

}  // namespace stiction::planning
