// The table of directions: nothing that is farthest is missing, whatever the points and the direction.
#include "stiction/contact/support_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "contact/shapes.hpp"

namespace stiction::contact {
namespace {

using detail::SupportTable;
using test::Random;
using test::Vector3d;

/// Corners of a prism with flat ends and chamfers, as links of robots have them: many points are equally far along its axis.
Eigen::Matrix3Xd make_rings(int corners) {
  Eigen::Matrix3Xd out(3, 4 * corners);
  int next = 0;
  for (const Eigen::Vector2d& ring : {Eigen::Vector2d(0.05, -0.2), {0.06, -0.19}, {0.06, 0.19}, {0.05, 0.2}}) {
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * EIGEN_PI * k / corners;
      out.col(next++) = Vector3d(0.5 + ring[0] * std::cos(angle), ring[0] * std::sin(angle), ring[1]);
    }
  }
  return out;
}

std::vector<Eigen::Matrix3Xd> make_sets(Random& random) {
  std::vector<Eigen::Matrix3Xd> out{make_rings(48), Eigen::Matrix3Xd::Zero(3, 1), Eigen::Matrix3Xd::Constant(3, 20, 0.3)};
  for (const int n : {4, 11, 12, 300}) {
    Eigen::Matrix3Xd points(3, n);
    for (int k = 0; k < n; ++k) points.col(k) = random.direction();
    out.push_back(points);
    out.push_back(points.array().colwise() * Eigen::Array3d(1, 1e-3, 0) + 2.0);  // thin and flat, far from the origin
  }
  return out;
}

std::vector<Vector3d> make_directions(Random& random) {
  std::vector<Vector3d> out;
  for (int x = -2; x <= 2; ++x) {  // axes, edges and corners of the cube, borders of cells
    for (int y = -2; y <= 2; ++y) {
      for (int z = -2; z <= 2; ++z) {
        if (x || y || z) out.emplace_back(x, y, z);
      }
    }
  }
  const std::size_t special = out.size();
  for (std::size_t i = 0; i < special; ++i) out.push_back((out[i] + 1e-9 * random.direction()) * std::pow(10, random.uniform(-12, 12)));
  for (int i = 0; i < 2000; ++i) out.push_back(random.direction());
  return out;
}

TEST(SupportTable, EveryDirection_HoldsAllThatAreNearlyFarthestInAscendingOrder) {
  Random random(1);
  const std::vector<Vector3d> directions = make_directions(random);
  for (const Eigen::Matrix3Xd& points : make_sets(random)) {
    const SupportTable table(points);
    const double size = 0.5 * (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
    for (const Vector3d& d : directions) {
      const std::span<const int> near = table.near(d);
      ASSERT_TRUE(std::is_sorted(near.begin(), near.end(), std::less_equal<>()));
      const Eigen::VectorXd height = points.transpose() * d;
      for (Eigen::Index i = 0; i < points.cols(); ++i) {
        if (height[i] < height.maxCoeff() - SupportTable::kNear * d.norm() * size) continue;
        ASSERT_TRUE(std::binary_search(near.begin(), near.end(), static_cast<int>(i)))
            << "point " << i << " of " << points.cols() << " along " << d.transpose();
      }
    }
  }
}

TEST(SupportTable, ManyPoints_FewAreLookedAt) {
  Random random(2);
  const Eigen::Matrix3Xd points = make_rings(48);
  const SupportTable table(points);
  double sum = 0;
  for (int i = 0; i < 2000; ++i) sum += static_cast<double>(table.near(random.direction()).size());
  EXPECT_LT(sum / 2000, 0.05 * static_cast<double>(points.cols()));
}

TEST(SupportTable, NoDirection_IsStillAnAnswer) {
  const Eigen::Matrix3Xd points = make_rings(8);
  const SupportTable table(points);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();
  for (const Vector3d& d : {Vector3d(0, 0, 0), Vector3d(kNan, 0, 1), Vector3d(kNan, kNan, kNan), Vector3d(kInfinity, -kInfinity, 1),
                            Vector3d(5e-324, 5e-324, 0)}) {
    for (const int i : table.near(d)) {
      EXPECT_GE(i, 0);
      EXPECT_LT(i, points.cols());
    }
  }
  EXPECT_TRUE(SupportTable().near(Vector3d::UnitX()).empty());
}

}  // namespace
}  // namespace stiction::contact
