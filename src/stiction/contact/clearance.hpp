#pragma once

#include <span>
#include <utility>
#include <vector>

#include "stiction/contact/contact.hpp"

namespace stiction::contact {

/// A pair of links that nearly touch where the robot rests: hulls of the file that come nearer to each other than robots keep elsewhere.
struct ClosePair {
  int pair = -1;
  double gap = 0;  ///< at rest [m] > 0

  /// Half of the gap: less than what others keep, and enough not to touch.
  double clearance() const { return 0.5 * gap; }
};

/// Pairs of links of one robot, and of links with fixed bodies, that are nearer than share::kClearance of the robots' length in the posture
/// Scene::rest, or neutral(), ascending. They are found once for each workspace.
/// Tests: tests/contact/clearance_test.cpp
std::span<const ClosePair> find_close_pairs(const world::Model& model, Workspace& work);

/// Pairs by the clearance that they are to keep.
struct PairClearances {
  double usual = 0;                             ///< [m]
  std::vector<int> pairs{};                     ///< that keep it
  std::vector<std::pair<int, double>> close{};  ///< that keep less: one of their own
};
PairClearances split_by_clearance(const world::Model& model, std::span<const int> pairs, double clearance, Workspace& work);

/// Whether a pair is nearer than a share of its clearance.
bool any_too_near(const world::Model& model, const world::Kinematics& kinematics, const PairClearances& pairs, double share,
                  Workspace& work);

}  // namespace stiction::contact
