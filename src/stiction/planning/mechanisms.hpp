#pragma once

#include <array>
#include <string_view>

namespace stiction::planning {

/// Parts that the planner adds to Algorithm 2, and that an ablation can leave out (bench/search.py --without).
///
/// Five more parts are always used, because plans without them are not accepted: sub-steps (Simulation), replay at half steps
/// (EdgeVerifier), simulated regrasps (Regrasp), limits on penetration, gap and press (contact_limits.hpp, press_limits.hpp), and a start
/// at rest (settle_start).
enum class Mechanism : unsigned {
  Frontier,        ///< nodes are extended in the order of (P.12): distance from the goal, visits of the node, visits of its cell
  Chains,          ///< another extension follows one that came nearer to its subgoal
  Sharpening,      ///< the barrier weight κ grows near the goal
  ForceCones,      ///< half of the extensions keep contact forces in their friction cones, to first order (P.7)
  Preload,         ///< pushes start with the preload of the grip (P.11)
  GraspChoice,     ///< of many postures in contact, those with the best local models are simulated
  StableReleases,  ///< objects must stay in place under tilted gravity while branches are released
  Restarts,        ///< a new tree replaces a tree that stalls
  SlipperyTrees,   ///< two trees in three plan with less friction
};
inline constexpr std::array<std::string_view, 9> kMechanismNames = {
    "frontier", "chains", "sharpening", "force_cones", "preload", "grasp_choice", "stable_releases", "restarts", "slippery_trees"};

}  // namespace stiction::planning
