#pragma once

#include "bindings.hpp"

namespace stiction::python {

/// A shape as Python sees it.
struct ShapeDict {
  nb::dict operator()(const world::Sphere& s) const { return of("sphere", "radius", s.radius); }
  nb::dict operator()(const world::Capsule& s) const { return with(of("capsule", "radius", s.radius), "half_length", s.half_length); }
  nb::dict operator()(const world::Box& s) const { return of("box", "half_extents", Eigen::VectorXd(s.half_extents)); }
  nb::dict operator()(const world::Cylinder& s) const { return with(of("cylinder", "radius", s.radius), "half_length", s.half_length); }
  nb::dict operator()(const world::HalfSpace&) const { return with(nb::dict(), "type", "half_space"); }
  nb::dict operator()(const world::Mesh& s) const {
    return with(of("mesh", "vertices", Rows(s.mesh->vertices.transpose())), "triangles", Triangles(s.mesh->triangles.transpose()));
  }

 private:
  using Triangles = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  template <class Value>
  static nb::dict with(nb::dict out, const char* key, const Value& value) {
    out[key] = value;
    return out;
  }
  template <class Value>
  static nb::dict of(const char* type, const char* key, const Value& value) {
    return with(with(nb::dict(), "type", type), key, value);
  }
};

}  // namespace stiction::python
