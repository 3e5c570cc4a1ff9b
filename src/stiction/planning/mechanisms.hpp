#pragma once

#include <array>
#include <string_view>

namespace stiction::planning {

/// What the planner adds to Algorithm 2 and can be left out for an ablation (bench/search.py --without).
///
/// Five more are no choice, since a plan without them is not accepted: sub-steps (Simulation), replay at half steps (EdgeVerifier), regrasps that are
/// simulated (Regrasp), limits of penetration, gap and press (contact_limits.hpp, press_limits.hpp), and a start at rest (settle_start).
enum class Mechanism : unsigned {
  Frontier,        ///< nodes are extended to the goal by distance, visits of the node and visits of its cell (P.12)
  Chains,          ///< an extension that gets nearer its subgoal is followed by another one
  Sharpening,      ///< κ grows near the goal
  ForceCones,      ///< half of the extensions keep contact forces in their cones to first order (P.7)
  Preload,         ///< pushes start with what is left of the grip (P.11)
  GraspChoice,     ///< of many postures that touch, those with the best local models are simulated
  StableReleases,  ///< objects must stay with gravity aside while branches let go
  Restarts,        ///< a tree that stalls makes room for a new one
  SlipperyTrees,   ///< every second tree plans with less friction
};
inline constexpr std::array<std::string_view, 9> kMechanismNames = {
    "frontier", "chains", "sharpening", "force_cones", "preload", "grasp_choice", "stable_releases", "restarts", "slippery_trees"};

}  // namespace stiction::planning
