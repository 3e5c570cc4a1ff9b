// Hulls with fewer corners: against the hull they come from, by support functions along many directions.
#include "stiction/world/simplify_hull.hpp"

#include <gtest/gtest.h>

#include <random>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

Vector3d direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

Matrix3Xd ellipsoid(int n, const Vector3d& half) {
  std::mt19937 random(3);
  Matrix3Xd out(3, n);
  for (int i = 0; i < n; ++i) out.col(i) = half.cwiseProduct(direction(random));
  return out;
}

/// The Hausdorff distance of convex bodies is the largest difference of their supports.
double largest_difference(const ConvexMesh& outer, const ConvexMesh& inner) {
  std::mt19937 random(5);
  double out = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d d = direction(random);
    const double difference = (d.transpose() * outer.vertices).maxCoeff() - (d.transpose() * inner.vertices).maxCoeff();
    EXPECT_GE(difference, -1e-12) << "the simplified hull is inside the given one";
    out = std::max(out, difference);
  }
  return out;
}

TEST(SimplifyHull, RoundBody_LosesCornersWithinTheTolerance) {
  for (const Vector3d& half : {Vector3d(1, 1, 1), Vector3d(0.02, 0.1, 0.3), Vector3d(1e3, 1e3, 50)}) {
    const ConvexMesh hull = make_convex_hull(ellipsoid(3000, half));
    for (const double share : {1e-2, 4e-3}) {
      const double tolerance = share * half.maxCoeff();
      const SimplifiedHull simple = simplify_hull(hull, tolerance);
      const double difference = largest_difference(hull, simple.mesh);
      EXPECT_LE(difference, tolerance);
      EXPECT_LE(difference, simple.error * (1 + 1e-9));
      EXPECT_GE(difference, 0.5 * simple.error) << "the error that is said is about that which is";
      EXPECT_LT(simple.mesh.vertices.cols(), 2.5 * 2.42 / share)
          << "a sphere needs 2.42/share corners: triangles with a sagitta of that share";
    }
  }
}

TEST(SimplifyHull, CornersThatAreNeeded_Stay) {
  Matrix3Xd box(3, 8);
  for (int i = 0; i < 8; ++i) box.col(i) << (i & 1 ? 0.1 : -0.1), (i & 2 ? 0.2 : -0.2), (i & 4 ? 0.3 : -0.3);
  const SimplifiedHull simple = simplify_hull(make_convex_hull(box), 1e-3);
  EXPECT_EQ(simple.mesh.vertices.cols(), 8);
  EXPECT_EQ(simple.error, 0);
}

/// The tip of a needle is farther from what is left than from its planes.
TEST(SimplifyHull, SharpTip_IsKept) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-1, 1);
  Matrix3Xd points(3, 200);
  for (int i = 0; i < 200; ++i) points.col(i) = Vector3d(place(random), place(random), 1e-3 * place(random));
  points.col(0) << 1.3, 0.4, 1e-3;
  points.col(1) << 1.295, 0.4, -1e-3;
  const ConvexMesh hull = make_convex_hull(points);
  for (const double tolerance : {0.3, 0.05, 0.004}) {
    const SimplifiedHull simple = simplify_hull(hull, tolerance);
    EXPECT_LE(largest_difference(hull, simple.mesh), tolerance);
  }
}

TEST(SimplifyHull, SameMesh_SameBits) {
  const ConvexMesh hull = make_convex_hull(ellipsoid(500, Vector3d::Ones()));
  EXPECT_EQ(simplify_hull(hull, 0.01).mesh.vertices, simplify_hull(hull, 0.01).mesh.vertices);
  EXPECT_EQ(simplify_hull(hull, 0).mesh.vertices.cols(), hull.vertices.cols());
  EXPECT_THROW(simplify_hull(hull, -1), core::InvalidInput);
}

}  // namespace
}  // namespace stiction::world
