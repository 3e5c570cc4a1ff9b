#pragma once

#include "stiction/contact/patch.hpp"

// Internal to the layer: the choice of the points of a patch that become contacts. docs/theory/patches.md.

namespace stiction::contact::detail {

/// Rounding error of a distance as a share of the bounding radii [-]. Points and normals that differ by less count as equal.
inline constexpr double kSame = 1e-9;
/// Code of the witness points of the pair, the largest code. Points whose codes coincide get other codes below it.
inline constexpr int kWitnessCode = 255;

/// Frame of the reference face.
struct PatchFrame {
  const Vector3d &e1, &e2, &m;  // axes in the face and its normal, in W
  double same;                  // heights and positions that differ by less count as equal [m]
};

/// Reduces scratch.gathered to at most Patch::kMost contacts, each with its own code. In a planar model the two ends and the lowest point
/// stay. Of too many points, those stay that touch first if the bodies tilt on each other.
void reduce_patch(const PatchFrame& frame, const PatchOptions& options, PatchScratch& scratch, Patch& out);

}  // namespace stiction::contact::detail
