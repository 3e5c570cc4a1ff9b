#pragma once

#include <array>

#include "stiction/contact/polytope.hpp"

// Internal to the layer: the contact points of flat features (patches). docs/theory/contact.md §9.

namespace stiction::contact::detail {

/// Contact points of one pair, sorted by code.
struct Patch {
  static constexpr int kMost = 8;

  struct Point {
    Distance at;
    PatchSide reference = PatchSide::None;
    PatchPoint kind = PatchPoint::Vertex;
    Vector3d edge_W{0, 0, 0}, side_W{0, 0, 0};
    int code = 0;  // names the features that meet here
  };

  std::array<Point, kMost> points;
  int n = 0;
};

/// A corner of a polygon during clipping: x, y in the reference face and the height z over it. `edge` is the edge that begins at this
/// corner: an edge of the incident polygon, or ~k for side k of the reference face.
struct ClipCorner {
  double x = 0, y = 0, z = 0;
  int edge = 0;
};

/// Storage of one thread; nothing in it outlives a query.
struct PatchScratch {
  std::vector<ClipCorner> polygon, clipped;
  std::vector<int> vertex;                   // names of the corners of the incident polygon
  std::vector<Vector3d> corner_W;            // positions of these corners
  std::vector<Patch::Point> gathered, kept;  // points before and after the reduction to kMost
  std::vector<int> order;                    // order of the gathered points
};

/// A shape and its pose.
struct Placed {
  const ShapeData& shape;
  const Pose& X_W;
  const ShapeData& solid;  // same as `shape`, but never extended across the plane of a planar model
};

struct PatchOptions {
  double limit = 0;         // points with phi ≥ limit are left out [m]
  int planar_axis = -1;     // axis perpendicular to the plane in which both shapes move, −1 if there is no such plane
  double planar_level = 0;  // coordinate of the contact points along this axis [m]
};

/// Whether the pair has a patch: one shape is a half-space or has flat faces, and neither is a sphere.
bool has_patch(const ShapeData& a, const ShapeData& b);

/// Computes the contacts of a pair from its distance d, kind(a) ≤ kind(b).
/// @param certain  false: d is only the separation along the normal of a face; it is the distance if some point of the patch attains it
/// @return false if d was not certain and no point attained it
bool calc_patch(const Placed& a, const Placed& b, const Distance& d, bool certain, const PatchOptions& options, PatchScratch& scratch,
                Patch& out);

/// Computes the largest separation of two boxes over their fifteen axes. It is their distance unless a corner of one box is nearest to a
/// corner or an edge of the other. If the separation is ≥ `limit`, the result may be any separation ≥ limit.
/// @returns true if it is the distance and two edges attain it at the witness points; false: see `certain` above
bool box_box(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, double limit, Distance& out);

}  // namespace stiction::contact::detail
