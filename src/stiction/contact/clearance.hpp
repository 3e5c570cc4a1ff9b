#pragma once

#include <span>
#include <utility>
#include <vector>

#include "stiction/contact/contact.hpp"

namespace stiction::contact {

/// A pair of links that nearly touch in the rest posture: their hulls in the robot file are closer than the clearance that other pairs
/// keep.
struct ClosePair {
  int pair = -1;
  double gap = 0;  ///< gap in the rest posture [m], > 0

  /// Clearance that this pair must keep: half of its gap at rest. It is smaller than that of other pairs, but large enough to avoid
  /// contact.
  double clearance() const { return 0.5 * gap; }
};

/// Finds the close pairs: two links of one robot, or a link and a fixed body, that are nearer than share::kClearance of the robots' length
/// in the posture Scene::rest, or else neutral(). The pairs are in ascending order and are computed once for each workspace.
/// Tests: tests/contact/clearance_test.cpp
std::span<const ClosePair> find_close_pairs(const world::Model& model, Workspace& work);

/// Pairs sorted by the clearance that they must keep.
struct PairClearances {
  double usual = 0;                             ///< usual clearance [m]
  std::vector<int> pairs{};                     ///< pairs that keep the usual clearance
  std::vector<std::pair<int, double>> close{};  ///< pairs that keep a smaller clearance of their own: (pair, clearance [m])
};
PairClearances split_by_clearance(const world::Model& model, std::span<const int> pairs, double clearance, Workspace& work);

/// Whether any pair is nearer than `share` times its clearance.
bool any_too_near(const world::Model& model, const world::Kinematics& kinematics, const PairClearances& pairs, double share,
                  Workspace& work);

}  // namespace stiction::contact
