#pragma once

#include "stiction/contact/shape_data.hpp"

// Internal to the layer: flat faces of shapes, merged from coplanar triangles once at load. docs/theory/contact.md §9.

namespace stiction::contact::detail {

/// Vertices and plane faces of a shape in its own frame: all of a box or mesh, the two caps of a cylinder.
struct Polytope {
  struct Face {
    Vector3d normal, e1, e2;   // outward; e1 × e2 = normal
    double d = 0;              // normal · x = d on the face, normal · x ≤ d everywhere else on the shape
    int begin = 0, count = 0;  // corners loop[begin], …, anticlockwise seen from outside
  };
  std::vector<Vector3d> vertices;
  std::vector<Face> faces;
  std::vector<int> loop;
  std::vector<Vector3d> sides;      // with `loop`: the side from corner k to the next, s·(x, y) ≤ c inside, as (s, c) in e1, e2
  SupportTable farthest, steepest;  // tables of the vertices and of the face normals
  std::vector<int> around, begin;   // faces around vertex v: around[begin[v]], …, before begin[v + 1]
};

/// Number of corners of a cap as a reference face: a polygon inscribed in the rim, which covers all but 1 % of the radius.
inline constexpr int kCapCorners = 24;
/// Number of points of a cap that are fixed in the body. They lie on a circle that this polygon contains in every orientation.
inline constexpr int kCapPoints = 6;

/// Faces of a box, cylinder or mesh; nullptr for shapes without any.
std::shared_ptr<const Polytope> make_polytope(const ShapeData& shape);

/// Face whose normal is nearest to the unit vector d, in the shape's frame.
int find_face(const Polytope& polytope, const Vector3d& d);

/// Vertex farthest along d, in the shape's frame; the first one at a tie.
int find_vertex(const Polytope& polytope, const Vector3d& d);

}  // namespace stiction::contact::detail
