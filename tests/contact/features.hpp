#pragma once
// Which feature of a shape carries a witness point, found from the normal alone: in other words than the library.

#include "contact/shapes.hpp"

namespace stiction::contact::test {

/// Sides of the faces, set of vertices, or part of a round shape; the same number means the same feature.
inline int find_feature(const world::Shape& shape, const Pose& X_WG, const Vector3d& p_W, const Vector3d& m_W) {
  const Vector3d m = X_WG.R.transpose() * m_W, p = X_WG.R.transpose() * (p_W - X_WG.p);
  const auto sign = [](double x) { return std::abs(x) < 1e-7 ? 0 : x < 0 ? 1 : 2; };
  if (std::holds_alternative<world::Box>(shape)) return sign(m.x()) + 3 * sign(m.y()) + 9 * sign(m.z());
  if (const auto* s = std::get_if<world::Mesh>(&shape)) {
    const Eigen::VectorXd height = s->mesh->vertices.transpose() * m;
    int code = 0;
    for (Eigen::Index i = 0; i < height.size(); ++i) code += height[i] > height.maxCoeff() - 1e-8 ? 1 << i : 0;
    return code;
  }
  if (const auto* s = std::get_if<world::Capsule>(&shape)) {
    const double z = p.z() - s->radius * m.z();
    return std::abs(z) < s->half_length - 1e-7 ? 0 : sign(z);
  }
  if (std::holds_alternative<world::Cylinder>(shape)) return sign(m.z()) + 3 * (m.head<2>().norm() > 1e-7);
  return 0;
}

}  // namespace stiction::contact::test
