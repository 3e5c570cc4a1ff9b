#pragma once

#include "stiction/contact/patch.hpp"

// Internal to the layer: which of the points in which features touch become contacts. docs/theory/patches.md.

namespace stiction::contact::detail {

/// Rounding of a distance, of the bounding radii [-]: points and normals this near count as one.
inline constexpr double kSame = 1e-9;
/// Code of the witness points of the pair, the last one; those of points that coincide are moved below it.
inline constexpr int kWitnessCode = 255;

/// Axes of the reference face and its normal, in W; where heights and places count as one [m].
struct PatchFrame {
  const Vector3d &e1, &e2, &m;
  double same;
};

/// Reduces scratch.gathered to at most Patch::kMost contacts: of a section the ends and the lowest point, of many points those that
/// touch first if the bodies tilt on each other; each with a code of its own.
void reduce_patch(const PatchFrame& frame, const PatchOptions& options, PatchScratch& scratch, Patch& out);

}  // namespace stiction::contact::detail
