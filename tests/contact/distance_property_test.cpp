// Signed distance where it is hard: touching, slightly penetrating and nearly parallel bodies, against bounds that no solver is needed for.
#include <gtest/gtest.h>

#include <numbers>

#include "contact/shapes.hpp"

namespace stiction::contact {
namespace {

using test::Random;
using test::Vector3d;
using world::Pose;

Eigen::Matrix3d turn(double angle, const Vector3d& axis) { return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(); }

/// Directions in which a shape has a flat side or a straight edge, in its own frame.
struct Directions {
  std::vector<Vector3d> faces, edges;
};

Directions find_directions(const world::Shape& shape) {
  Directions out;
  if (std::holds_alternative<world::Box>(shape)) {
    for (int k = 0; k < 3; ++k) {
      out.faces.push_back(Vector3d::Unit(k));
      out.faces.push_back(-Vector3d::Unit(k));
      out.edges.push_back(Vector3d::Unit(k));
    }
  } else if (std::holds_alternative<world::Cylinder>(shape)) {
    out.faces = {Vector3d::UnitZ(), -Vector3d::UnitZ()};
    out.edges = {Vector3d::UnitZ()};
  } else if (const auto* s = std::get_if<world::Mesh>(&shape)) {
    const world::ConvexMesh& m = *s->mesh;
    for (Eigen::Index i = 0; i < m.triangles.cols(); ++i) {
      const Vector3d a = m.vertices.col(m.triangles(0, i)), b = m.vertices.col(m.triangles(1, i)), c = m.vertices.col(m.triangles(2, i));
      out.faces.push_back((b - a).cross(c - a).normalized());
      for (const Vector3d& e : {Vector3d(b - a), Vector3d(c - b), Vector3d(a - c)}) out.edges.push_back(e.normalized());
    }
  }
  return out;
}

/// Largest separation along the normals of both shapes and the common perpendiculars of their edges and axes: phi is no smaller.
double canonical_separation(const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB) {
  const Directions of_a = find_directions(a), of_b = find_directions(b);
  double best = -1e300;
  const auto meet = [&](const Vector3d& n) { best = std::max(best, test::gap_along(a, X_WA, b, X_WB, n)); };
  for (const Vector3d& n : of_a.faces) meet(-(X_WA.R * n));
  for (const Vector3d& n : of_b.faces) meet(X_WB.R * n);
  for (const Vector3d& u : of_a.edges) {
    for (const Vector3d& v : of_b.edges) {
      const Vector3d n = (X_WA.R * u).cross(X_WB.R * v);
      if (n.norm() < 1e-14) continue;
      meet(n.normalized());
      meet(-n.normalized());
    }
  }
  return best;
}

/// Distance of two points, one of each body: by projection back and forth, with the closed forms of a point against each shape.
double distance_of_points(const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB, int rounds) {
  Vector3d x = X_WA.p, y = X_WB.p;
  const auto project = [](const world::Shape& shape, const Pose& X, const Vector3d& p) {
    const Distance d = calc_distance(world::Sphere{0.0}, {Eigen::Matrix3d::Identity(), p}, shape, X);
    return d.phi > 0 ? d.p_WB : p;
  };
  for (int k = 0; k < rounds; ++k) {
    y = project(b, X_WB, x);
    x = project(a, X_WA, y);
  }
  return (x - y).norm();
}

struct PairCase {
  std::string name;
  world::Shape a, b;
  double tolerance = 1e-9;  // [m]; two boxes: 1e-12 of the sizes for either of two answers
};
void PrintTo(const PairCase& c, std::ostream* os) { *os << c.name; }

/// A at a small gap from B along a canonical direction of B or any other, turned so that its own directions are nearly those of B.
Pose make_pose(Random& random, const PairCase& pair, const Pose& X_WB, int i) {
  const Directions of_b = find_directions(pair.b);
  const auto pick = [&](const std::vector<Vector3d>& from) {
    return from[static_cast<std::size_t>(random.uniform(0, static_cast<double>(from.size()) - 1e-9))];
  };
  const Vector3d axes[] = {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
  const Eigen::Matrix3d base = Eigen::Quaterniond::FromTwoVectors(axes[i % 3], pick(of_b.edges)).toRotationMatrix();
  const double tilt = i % 4 == 0 ? 0.0 : std::pow(10.0, random.uniform(-12, 0));
  const Vector3d towards = i % 5 == 0 ? random.direction() : pick(of_b.faces);
  const Eigen::Matrix3d R = i % 7 == 0 ? random.rotation() : Eigen::Matrix3d(X_WB.R * turn(tilt, random.direction()) * base);
  const Vector3d n = X_WB.R * (towards + std::pow(10.0, random.uniform(-12, -0.5)) * random.direction()).normalized();
  constexpr double gaps[] = {0.0, -1e-12, 1e-12, -1e-9, 1e-9, -1e-6, 1e-6, -1e-4, 1e-4, -2e-3, 5e-3};
  Pose X_WA{R, X_WB.p};
  X_WA.p += n * (gaps[(i / 3) % 11] - test::gap_along(pair.a, X_WA, pair.b, X_WB, n));
  const Vector3d aside = random.in_cube(0.08);
  X_WA.p += aside - n * n.dot(aside);
  return X_WA;
}

class HardPoses : public ::testing::TestWithParam<PairCase> {};
INSTANTIATE_TEST_SUITE_P(Pairs, HardPoses,
                         ::testing::Values(PairCase{"cylinder_cylinder", world::Cylinder{0.04, 0.06}, world::Cylinder{0.05, 0.03}},
                                           PairCase{"cylinder_box", world::Cylinder{0.04, 0.06}, world::Box{{0.05, 0.03, 0.08}}},
                                           PairCase{"box_box", world::Box{{0.05, 0.03, 0.08}}, world::Box{{0.05, 0.06, 0.02}}, 4e-13},
                                           PairCase{"cylinder_mesh", world::Cylinder{0.04, 0.06}, test::make_mesh()}),
                         [](const auto& p) { return p.param.name; });

TEST_P(HardPoses, PhiLiesBetweenItsBounds) {
  const PairCase& pair = GetParam();
  Random random(21);
  const double tolerance = pair.tolerance;
  int near = 0;
  for (int i = 0; i < 20000; ++i) {
    const Pose X_WB = random.pose(0.1), X_WA = make_pose(random, pair, X_WB, i);
    const Distance d = calc_distance(pair.a, X_WA, pair.b, X_WB), e = calc_distance(pair.b, X_WB, pair.a, X_WA);
    near += std::abs(d.phi) < 1e-3;
    EXPECT_GE(d.phi, canonical_separation(pair.a, X_WA, pair.b, X_WB) - tolerance) << i;
    EXPECT_NEAR(d.phi, e.phi, tolerance) << i;
    EXPECT_LE((d.p_WA - d.p_WB - d.phi * d.nhat_BA_W).norm(), 1e-14) << i;
    EXPECT_NEAR(test::gap_along(pair.a, X_WA, pair.b, X_WB, d.nhat_BA_W), d.phi, tolerance) << i;
    EXPECT_LE(test::outside(pair.a, X_WA, d.p_WA), tolerance) << i << " phi " << d.phi;
    EXPECT_LE(test::outside(pair.b, X_WB, d.p_WB), tolerance) << i << " phi " << d.phi;
    if (i % 20 == 0) {
      EXPECT_LE(d.phi, distance_of_points(pair.a, X_WA, pair.b, X_WB, 20) + tolerance) << i;
    }
  }
  EXPECT_GT(near, 2000);
}

}  // namespace
}  // namespace stiction::contact
