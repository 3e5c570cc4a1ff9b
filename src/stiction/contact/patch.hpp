#pragma once

#include <array>

#include "stiction/contact/polytope.hpp"

// Internal to the layer: the points in which flat features touch. docs/theory/contact.md §9.

namespace stiction::contact::detail {

/// Contacts of one pair, in the order of their codes.
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

/// A corner of a polygon on its way through the clipping: coordinates in the reference face and height over it. `edge` is the edge
/// that begins here: of the incident polygon, or ~k for side k of the reference face.
struct ClipCorner {
  double x = 0, y = 0, z = 0;
  int edge = 0;
};

/// Storage of one thread; nothing in it outlives a query.
struct PatchScratch {
  std::vector<ClipCorner> polygon, clipped;
  std::vector<int> vertex;                   // names of the corners of the incident polygon
  std::vector<Vector3d> corner_W;            // and where they are
  std::vector<Patch::Point> gathered, kept;  // before and after the choice of kMost
  std::vector<int> order;                    // of those gathered
};

/// A shape in its place.
struct Placed {
  const ShapeData& shape;
  const Pose& X_W;
  const ShapeData& solid;  // as `shape`, but never made long across the plane of a planar model
};

struct PatchOptions {
  double limit = 0;         // points from this distance on are left out [m]
  int planar_axis = -1;     // axis across the plane in which both shapes move, −1 without one
  double planar_level = 0;  // their coordinate along it [m]
};

/// Has the pair a patch: one of the two is a half-space or has flat faces, and none is a sphere.
bool has_patch(const ShapeData& a, const ShapeData& b);

/// Contacts of a before b, kind(a) ≤ kind(b), from their distance.
/// @param certain  false: d is the separation along the normal of a face, and their distance only if a point of the patch attains it
/// @return false: d was not certain, and no point attained it
bool calc_patch(const Placed& a, const Placed& b, const Distance& d, bool certain, const PatchOptions& options, PatchScratch& scratch,
                Patch& out);

/// Largest separation of two boxes over their fifteen axes, which is their distance unless a corner of one is nearest to a corner or an
/// edge of the other. True: it is the distance, and edges attain it in the witness points. False: see `certain` above.
/// A pair with a separation ≥ `limit` may come back with any separation ≥ limit.
bool box_box(const ShapeData& a, const Pose& X_WA, const ShapeData& b, const Pose& X_WB, double limit, Distance& out);

}  // namespace stiction::contact::detail
