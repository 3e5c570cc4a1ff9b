#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/planning/planner.hpp"
#include "stiction/world/model.hpp"

namespace stiction::planning {

struct PackingOptions {
  double threshold = 3;  ///< η in (3.9), of the form eᵀ(B_uB_uᵀ + γI)⁻¹e [-] > 0
  double gamma = 1e-6;   ///< γ of that form > 0
  int samples = 1000;    ///< N, ≥ 1; the standard error of a ratio r is √(r(1 − r)/N)
  std::uint64_t seed = 0;
  void validate() const;
};

/// Packing ratio (3.9) of a tree after each of its nodes: the share of N configurations drawn from the boxes that lie within η of a node,
/// each under its own metric (3.5). Objects without a box stay where the root has them. The ratio never falls and lies in [0, 1].
/// @returns one number per node; empty for an empty tree
/// @throws  InvalidInput: η, γ ≤ 0, N < 1, no box
/// Tests: tests/planning/packing_test.cpp (ellipsoids of known volume)
Eigen::VectorXd calc_packing_ratio(const world::Model& model, const std::vector<world::SampleBox>& boxes,
                                   const std::vector<NodeRecord>& tree, const PackingOptions& options = {});

}  // namespace stiction::planning
