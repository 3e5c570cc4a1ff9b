#include "stiction/world/ellipsoid.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stiction/world/shapes.hpp"
#include "support/message_of.hpp"

namespace stiction::world::test {
namespace {

/// With the axes scaled to one, every face of the polytope is about as far from the centre as the unit sphere.
TEST(Ellipsoid, Polytope_StaysWithinItsError) {
  const Eigen::Vector3d radii(0.03, 0.05, 0.04);
  const ConvexMesh mesh = make_ellipsoid(radii);
  double farthest = 0, nearest = 2;
  for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i) farthest = std::max(farthest, mesh.vertices.col(i).cwiseQuotient(radii).norm());
  for (Eigen::Index i = 0; i < mesh.triangles.cols(); ++i) {
    const auto corner = [&](int k) -> Eigen::Vector3d { return mesh.vertices.col(mesh.triangles(k, i)).cwiseQuotient(radii); };
    const Eigen::Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    nearest = std::min(nearest, n.dot(corner(0)));
  }
  EXPECT_NEAR(farthest, 1 + kEllipsoidError, 1e-12);
  EXPECT_GT(nearest, 1 - kEllipsoidError);
  EXPECT_LT(nearest, 1) << "it is no sphere";
}

TEST(Ellipsoid, VolumeAndInertia_AreThoseOfTheFormula) {
  const Eigen::Vector3d r(0.03, 0.05, 0.04);
  const VolumeProperties p = calc_volume_properties(Mesh{std::make_shared<const ConvexMesh>(make_ellipsoid(r))});
  const double volume = 4.0 / 3 * M_PI * r.prod();
  EXPECT_NEAR(p.volume / volume, 1, 0.02);
  EXPECT_LT(p.center.norm(), 1e-9);
  EXPECT_NEAR(p.inertia(0, 0) / (volume / 5 * (r[1] * r[1] + r[2] * r[2])), 1, 0.03);
}

}  // namespace
}  // namespace stiction::world::test
