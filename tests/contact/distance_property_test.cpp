// Signed distance where it is hard: touching, slightly penetrating and nearly parallel bodies, against bounds that no solver is needed for.
#include <gtest/gtest.h>

#include <numbers>

#include "contact/shapes.hpp"

namespace stiction::contact {
namespace {

using test::Random;
using test::turn;
using test::Vector3d;
using world::Pose;

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

struct HardPair {
  std::string name;
  world::Shape a, b;
  double tolerance = 1e-9;  // [m]; two boxes: 1e-12 of the sizes for either of two answers
};
void PrintTo(const HardPair& c, std::ostream* os) { *os << c.name; }

/// A at a small gap from B along a canonical direction of B or any other, turned so that its own directions are nearly those of B.
Pose make_pose(Random& random, const HardPair& pair, const Pose& X_WB, int i) {
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

class HardPoses : public ::testing::TestWithParam<HardPair> {};
INSTANTIATE_TEST_SUITE_P(Pairs, HardPoses,
                         ::testing::Values(HardPair{"cylinder_cylinder", world::Cylinder{0.04, 0.06}, world::Cylinder{0.05, 0.03}},
                                           HardPair{"cylinder_box", world::Cylinder{0.04, 0.06}, world::Box{{0.05, 0.03, 0.08}}},
                                           HardPair{"box_box", world::Box{{0.05, 0.03, 0.08}}, world::Box{{0.05, 0.06, 0.02}}, 4e-13},
                                           HardPair{"cylinder_mesh", world::Cylinder{0.04, 0.06}, test::make_mesh()}),
                         [](const auto& p) { return p.param.name; });

TEST_P(HardPoses, PhiLiesBetweenItsBounds) {
  const HardPair& pair = GetParam();
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

// Two round bodies on one axis: the shortest way out is along it or, all around, to the side.
TEST(RoundBodies, OnOneAxis_DepthIsTheShorterWayOut) {
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    const double scale = std::pow(10.0, random.uniform(-2, 2));
    const double r_a = scale * random.uniform(0.01, 0.1), r_b = scale * random.uniform(0.01, 0.1);
    const double l_a = scale * random.uniform(0.02, 0.4), l_b = scale * random.uniform(0.02, 0.4);
    const Pose X_WB = random.pose(scale);
    Pose X_WA = X_WB;
    const double off = random.uniform(-0.4, 0.4) * (l_a + l_b);
    X_WA.p += off * X_WB.R.col(2);
    X_WA.R = X_WB.R * turn(random.uniform(0, std::numbers::pi), Vector3d::UnitZ());
    const double sides = r_a + r_b;
    const double tolerance = 1e-9 * scale;
    EXPECT_NEAR(calc_distance(world::Cylinder{r_a, l_a}, X_WA, world::Cylinder{r_b, l_b}, X_WB).phi,
                -std::min(l_a + l_b - std::abs(off), sides), tolerance)
        << i;
    EXPECT_NEAR(calc_distance(world::Capsule{r_a, l_a}, X_WA, world::Cylinder{r_b, l_b}, X_WB).phi,
                -std::min(l_a + l_b - std::abs(off) + r_a, sides), tolerance)
        << i;
  }
}

// A corner of a mesh of metres a nanometre over a face of a box of metres.
TEST(LargeBodies, CornerNanometresOverAFace_GapIsTheSeparation) {
  auto m = std::make_shared<world::ConvexMesh>();
  m->vertices.resize(3, 4);
  m->vertices << 0, 0.5, -0.25, -0.25, 0, 0, 0.5, -0.5, 0, 0.75, 0.75, 0.75;
  m->triangles.resize(3, 4);
  m->triangles << 0, 0, 0, 1, 2, 3, 1, 2, 1, 2, 3, 3;
  Random random(9);
  const Vector3d half(1.5, 1, 0.5);
  for (int i = 0; i < 3000; ++i) {
    const double scale = std::pow(10.0, i % 5 - 3), gap = scale * std::pow(10.0, random.uniform(-9, -6));
    world::Mesh tip{std::make_shared<world::ConvexMesh>(*m)};
    std::const_pointer_cast<world::ConvexMesh>(tip.mesh)->vertices *= scale;
    const world::Box box{scale * half};
    const Pose X_WB = random.pose(0);
    Pose X_WA{random.rotation(), Vector3d::Zero()};
    const int k = i % 3;
    const double side = i % 2 ? 1 : -1;
    if (test::gap_along(tip, X_WA, box, X_WB, side * X_WB.R.col(k)) < -scale * half[k] - 1e-12 * scale) continue;  // the tip is not lowest
    Vector3d at = scale * half.cwiseProduct(random.in_cube(0.3));
    at[k] = side * (scale * half[k] + gap);
    X_WA.p = X_WB * at;
    EXPECT_NEAR(calc_distance(tip, X_WA, box, X_WB).phi, gap, 1e-14 * scale) << i << " scale " << scale;
    EXPECT_NEAR(calc_distance(box, X_WB, tip, X_WA).phi, gap, 1e-14 * scale) << i << " scale " << scale;
  }
}

/// A round plate of n corners whose caps are fans, or a cone with its tip in place of the upper cap.
world::Mesh make_round(int n, double radius, double height, bool cone) {
  auto m = std::make_shared<world::ConvexMesh>();
  m->vertices.resize(3, cone ? n + 1 : 2 * n);
  std::vector<Eigen::Vector3i> triangles;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    const Vector3d corner(radius * std::cos(angle), radius * std::sin(angle), -0.5 * height);
    const int next = (i + 1) % n;
    m->vertices.col(i) = corner;
    if (i > 0 && i < n - 1) triangles.emplace_back(0, i + 1, i);
    if (cone) {
      triangles.emplace_back(i, next, n);
      continue;
    }
    m->vertices.col(n + i) = corner + height * Vector3d::UnitZ();
    if (i > 0 && i < n - 1) triangles.emplace_back(n, n + i, n + i + 1);
    triangles.emplace_back(i, next, n + i);
    triangles.emplace_back(next, n + next, n + i);
  }
  if (cone) m->vertices.col(n) = Vector3d(0, 0, 0.5 * height);
  m->triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t i = 0; i < triangles.size(); ++i) m->triangles.col(static_cast<Eigen::Index>(i)) = triangles[i];
  return {m};
}

TEST(RoundMesh, CapThatIsOneFan_IsABodyLikeAnyOther) {
  Random random(3);
  const world::Mesh plate = make_round(300, 0.1, 0.2, false);
  const world::Box box{{0.4, 0.4, 0.05}};
  for (int i = 0; i < 100; ++i) {
    const Pose X_WB = random.pose(0.1);
    const double gap = random.uniform(0.0, 0.05);
    Pose X_WA = X_WB;
    X_WA.p += (0.05 + 0.1 + gap) * X_WB.R.col(2);
    EXPECT_NEAR(calc_distance(plate, X_WA, box, X_WB).phi, gap, 1e-12);
  }
}

TEST(RoundMesh, TipWithHundredsOfEdges_IsACornerLikeAnyOther) {
  Random random(4);
  const world::Mesh cone = make_round(300, 0.1, 0.2, true);
  const world::Box box{{0.4, 0.4, 0.05}};
  for (int i = 0; i < 100; ++i) {
    const Pose X_WB = random.pose(0.1);
    const double gap = random.uniform(-0.01, 0.05);
    Pose X_WA = X_WB;
    X_WA.R = X_WB.R * turn(std::numbers::pi + random.uniform(-0.5, 0.5), Vector3d::UnitX());
    X_WA.p += X_WB.R * Vector3d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 0.05 + gap) - X_WA.R * Vector3d(0, 0, 0.1);
    EXPECT_NEAR(calc_distance(cone, X_WA, box, X_WB).phi, gap, 1e-12);
  }
}

}  // namespace
}  // namespace stiction::contact
