// Signed distance of every pair of shapes: closed numbers, certificates of optimality, symmetries, continuity, degenerate cases.
#include <gtest/gtest.h>

#include <numbers>

#include "contact/shapes.hpp"
#include "stiction/contact/shape_data.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact {
namespace {

using test::Random;
using test::turn;
using test::Vector3d;
using world::Pose;

Pose at(double x, double y, double z) { return {Eigen::Matrix3d::Identity(), {x, y, z}}; }

void expect_near(const Vector3d& got, const Vector3d& want, double tolerance, const std::string& what) {
  EXPECT_LE((got - want).norm(), tolerance) << what << ": got " << got.transpose() << ", expected " << want.transpose();
}

void expect(const Distance& d, double phi, const Vector3d& n, const Vector3d& p_a, const Vector3d& p_b, double tolerance = 1e-14) {
  EXPECT_NEAR(d.phi, phi, 1e-14);
  expect_near(d.nhat_BA_W, n, 1e-14, "normal");
  expect_near(d.p_WA, p_a, tolerance, "point on A");
  expect_near(d.p_WB, p_b, tolerance, "point on B");
}

/// What holds for every answer, whatever the shapes.
void expect_consistent(const Distance& d, const std::string& what) {
  EXPECT_TRUE(std::isfinite(d.phi) && d.p_WA.allFinite() && d.p_WB.allFinite() && d.nhat_BA_W.allFinite()) << what;
  EXPECT_NEAR(d.nhat_BA_W.norm(), 1.0, 1e-12) << what;
  expect_near(d.p_WA - d.p_WB, d.phi * d.nhat_BA_W, 1e-14, what + ": p_WA − p_WB = phi nhat");
}

struct NamedPair {
  test::Named a, b;
  std::string name() const { return a.name + "_" + b.name; }
};
void PrintTo(const NamedPair& c, std::ostream* os) { *os << c.name(); }
std::string case_name(const ::testing::TestParamInfo<NamedPair>& info) { return info.param.name(); }

std::vector<NamedPair> all_pairs() {
  std::vector<NamedPair> out;
  for (const auto& a : test::all_shapes()) {
    for (const auto& b : test::all_shapes()) {
      if (!(test::is_half_space(a.shape) && test::is_half_space(b.shape))) out.push_back({a, b});
    }
  }
  return out;
}

class EveryPair : public ::testing::TestWithParam<NamedPair> {
 protected:
  const world::Shape& a() const { return GetParam().a.shape; }
  const world::Shape& b() const { return GetParam().b.shape; }
};
INSTANTIATE_TEST_SUITE_P(Shapes, EveryPair, ::testing::ValuesIn(all_pairs()), case_name);

// --- closed numbers ---------------------------------------------------------------------------------------------------------

TEST(SphereSphere, ApartAndOverlapping_ClosedNumbers) {
  expect(calc_distance(world::Sphere{0.1}, at(0.5, 0, 0), world::Sphere{0.2}, at(0, 0, 0)), 0.2, {1, 0, 0}, {0.4, 0, 0}, {0.2, 0, 0});
  expect(calc_distance(world::Sphere{0.1}, at(0, 0.25, 0), world::Sphere{0.2}, at(0, 0, 0)), -0.05, {0, 1, 0}, {0, 0.15, 0}, {0, 0.2, 0});
}

TEST(SphereSphere, CoincidentCentres_NormalIsZ) {
  expect(calc_distance(world::Sphere{0.1}, at(1, 2, 3), world::Sphere{0.2}, at(1, 2, 3)), -0.3, {0, 0, 1}, {1, 2, 2.9}, {1, 2, 3.2});
}

TEST(SphereCapsule, SideEndAndInside_ClosedNumbers) {
  const world::Capsule capsule{0.1, 0.5};
  expect(calc_distance(world::Sphere{0.2}, at(0.5, 0, 0.25), capsule, at(0, 0, 0)), 0.2, {1, 0, 0}, {0.3, 0, 0.25}, {0.1, 0, 0.25});
  expect(calc_distance(world::Sphere{0.2}, at(0, 0, 1), capsule, at(0, 0, 0)), 0.2, {0, 0, 1}, {0, 0, 0.8}, {0, 0, 0.6});
  expect(calc_distance(world::Sphere{0.2}, at(0, -0.05, 0.25), capsule, at(0, 0, 0)), -0.25, {0, -1, 0}, {0, 0.15, 0.25}, {0, -0.1, 0.25});
}

TEST(SphereBox, InsideTakesNearestFace_OutsideTakesNearestPoint) {
  const world::Box box{{0.3, 0.2, 0.1}};
  expect(calc_distance(world::Sphere{0.01}, at(0, 0.19, 0.05), box, at(0, 0, 0)), -0.02, {0, 1, 0}, {0, 0.18, 0.05}, {0, 0.2, 0.05});
  expect(calc_distance(world::Sphere{0.01}, at(0.29, 0, -0.02), box, at(0, 0, 0)), -0.02, {1, 0, 0}, {0.28, 0, -0.02}, {0.3, 0, -0.02});
  expect(calc_distance(world::Sphere{0.05}, at(0.1, 0, 0.4), box, at(0, 0, 0)), 0.25, {0, 0, 1}, {0.1, 0, 0.35}, {0.1, 0, 0.1});
  expect(calc_distance(world::Sphere{0.02}, at(0.33, 0.24, 0), box, at(0, 0, 0)), 0.03, {0.6, 0.8, 0}, {0.318, 0.224, 0}, {0.3, 0.2, 0});
  // Exactly in the middle of a cube: the first axis, upwards.
  expect(calc_distance(world::Sphere{0.0}, at(0, 0, 0), world::Box{{1, 1, 1}}, at(0, 0, 0)), -1.0, {1, 0, 0}, {0, 0, 0}, {1, 0, 0});
}

TEST(SphereCylinder, SideCapRimAndInside_ClosedNumbers) {
  const world::Cylinder cylinder{0.3, 0.5};
  const Pose O = at(0, 0, 0);
  expect(calc_distance(world::Sphere{0.1}, at(0, 0.6, 0.2), cylinder, O), 0.2, {0, 1, 0}, {0, 0.5, 0.2}, {0, 0.3, 0.2});
  expect(calc_distance(world::Sphere{0.1}, at(0.1, 0, -0.9), cylinder, O), 0.3, {0, 0, -1}, {0.1, 0, -0.8}, {0.1, 0, -0.5});
  expect(calc_distance(world::Sphere{0.01}, at(0.33, 0, 0.54), cylinder, O), 0.04, {0.6, 0, 0.8}, {0.324, 0, 0.532}, {0.3, 0, 0.5});
  expect(calc_distance(world::Sphere{0.01}, at(0.28, 0, 0.1), cylinder, O), -0.03, {1, 0, 0}, {0.27, 0, 0.1}, {0.3, 0, 0.1});
  expect(calc_distance(world::Sphere{0.01}, at(0.1, 0, 0.45), cylinder, O), -0.06, {0, 0, 1}, {0.1, 0, 0.44}, {0.1, 0, 0.5});
  expect(calc_distance(world::Sphere{0.01}, at(0, 0, 0), cylinder, O), -0.31, {1, 0, 0}, {-0.01, 0, 0}, {0.3, 0, 0});
}

TEST(SphereMesh, BoxAsMesh_EqualsBox) {
  const Vector3d half(0.05, 0.03, 0.08);
  const world::Mesh mesh = test::make_box_mesh(half);
  Random random(3);
  int inside = 0;
  for (int i = 0; i < 3000; ++i) {
    const Pose X_WA = random.pose(0.12), X_WB = random.pose(0.02);
    const Distance m = calc_distance(world::Sphere{0.02}, X_WA, mesh, X_WB),
                   b = calc_distance(world::Sphere{0.02}, X_WA, world::Box{half}, X_WB);
    EXPECT_NEAR(m.phi, b.phi, 1e-14);
    expect_near(m.nhat_BA_W, b.nhat_BA_W, 1e-10, "normal");  // amplified by 1 / distance of the centre to the surface
    expect_near(m.p_WB, b.p_WB, 1e-13, "point");
    inside += b.phi < -0.02;
  }
  EXPECT_GT(inside, 50);
}

TEST(CapsuleCapsule, CrossedParallelAndCollinear_StatedSelection) {
  const world::Capsule c{0.1, 0.5};
  const Pose along_x{turn(std::numbers::pi / 2, Vector3d::UnitY()), {0, 0, 0}};
  const Pose along_y{turn(-std::numbers::pi / 2, Vector3d::UnitX()), {0, 0, 0.3}};
  expect(calc_distance(c, along_y, c, along_x), 0.1, {0, 0, 1}, {0, 0, 0.2}, {0, 0, 0.1});
  // Axes that meet: ±(axis A × axis B), the same line for every order of the two.
  Distance d = calc_distance(c, Pose{along_y.R, {0, 0, 0}}, c, along_x);
  EXPECT_NEAR(d.phi, -0.2, 1e-15);
  EXPECT_NEAR(std::abs(d.nhat_BA_W.z()), 1.0, 1e-14);
  expect_consistent(d, "crossing");
  // Parallel, overlapping by 0.6: the middle of the overlap.
  expect(calc_distance(c, at(0.5, 0, 0.4), c, at(0, 0, 0)), 0.3, {1, 0, 0}, {0.4, 0, 0.2}, {0.1, 0, 0.2});
  // Antiparallel, one inside the other's length.
  expect(calc_distance(world::Capsule{0.1, 0.2}, Pose{turn(std::numbers::pi, Vector3d::UnitX()), {0.5, 0, 0.1}}, c, at(0, 0, 0)), 0.3,
         {1, 0, 0}, {0.4, 0, 0.1}, {0.1, 0, 0.1});
  // Parallel without overlap: end against end.
  d = calc_distance(c, at(0.3, 0, 1.4), c, at(0, 0, 0));
  EXPECT_NEAR(d.phi, 0.5 - 0.2, 1e-14);
  expect_near(d.nhat_BA_W, {0.6, 0, 0.8}, 1e-14, "normal");
  // Collinear and overlapping: any normal square to the axes will do, never NaN.
  d = calc_distance(c, at(0, 0, 0.2), c, at(0, 0, 0));
  EXPECT_NEAR(d.phi, -0.2, 1e-15);
  EXPECT_NEAR(d.nhat_BA_W.z(), 0, 1e-15);
  expect_consistent(d, "collinear");
  EXPECT_NEAR(d.p_WB.z(), 0.1, 1e-15);
}

TEST(CapsuleCapsule, NearlyParallel_PhiIsExactAndWitnessTurnsContinuously) {
  const world::Capsule c{0.01, 0.05};
  Vector3d last;
  double last_angle = 0;
  for (int i = 0; i <= 4000; ++i) {
    const double angle = std::pow(10.0, -10.0 + i * 0.002) - 1e-10;  // 0 … 1e-2 rad
    const Pose X_WA{turn(angle, Vector3d::UnitY()), {0.03, 0, 0.02}};
    const Distance d = calc_distance(c, X_WA, c, at(0, 0, 0));
    // Closed form in the plane: the lower end of A is nearest for a positive angle, and it faces B's side.
    const Vector3d low = X_WA * Vector3d(0, 0, -0.05);
    EXPECT_NEAR(d.phi, low.x() - 0.02, 1e-12) << "angle " << angle;
    if (i > 0) {
      EXPECT_LT((d.p_WA - last).norm(), 0.05 * (angle - last_angle) / 1e-7 + 1e-9) << "angle " << angle;
    }
    last = d.p_WA;
    last_angle = angle;
  }
  EXPECT_NEAR(calc_distance(c, at(0.03, 0, 0.02), c, at(0, 0, 0)).p_WA.z(), 0.01, 1e-15);
}

TEST(HalfSpace, FlatShapes_TouchInTheMiddleOfTheirSupport) {
  const world::HalfSpace ground;
  const Pose O;
  expect(calc_distance(world::Sphere{0.1}, at(1, 2, 0.05), ground, O), -0.05, {0, 0, 1}, {1, 2, -0.05}, {1, 2, 0});
  expect(calc_distance(world::Box{{0.3, 0.2, 0.1}}, at(1, 2, 0.1), ground, O), 0.0, {0, 0, 1}, {1, 2, 0}, {1, 2, 0});
  const Eigen::Matrix3d lie = turn(std::numbers::pi / 2, Vector3d::UnitX());
  // cos(π/2) is 6e-17 and not 0: times length² / level it moves the point by 5e-10.
  expect(calc_distance(world::Capsule{0.1, 0.4}, {lie, {1, 2, 0.3}}, ground, O), 0.2, {0, 0, 1}, {1, 2, 0.2}, {1, 2, 0}, 1e-9);
  expect(calc_distance(world::Cylinder{0.1, 0.4}, {lie, {1, 2, 0.3}}, ground, O), 0.2, {0, 0, 1}, {1, 2, 0.2}, {1, 2, 0}, 1e-9);
  expect(calc_distance(world::Cylinder{0.1, 0.4}, at(1, 2, 0.3), ground, O), -0.1, {0, 0, 1}, {1, 2, -0.1}, {1, 2, 0});
  expect(calc_distance(test::make_box_mesh({0.3, 0.2, 0.1}), at(1, 2, 0.1), ground, O), 0.0, {0, 0, 1}, {1, 2, 0}, {1, 2, 0});
  // Tilted about x: the edge, at its middle.
  const Pose tilted{turn(0.3, Vector3d::UnitX()), {0, 0, 1}};
  const Vector3d edge = tilted * Vector3d(0, -0.2, -0.1);
  expect(calc_distance(world::Box{{0.3, 0.2, 0.1}}, tilted, ground, O), edge.z(), {0, 0, 1}, edge, {edge.x(), edge.y(), 0});
}

TEST(HalfSpace, TiltingBox_WitnessMovesWithoutJump) {
  const world::Box box{{0.05, 0.03, 0.02}};
  const double level = 1e-7 * box.half_extents.norm();
  Vector3d last = calc_distance(box, {turn(-2e-6, Vector3d(0, 1, 0)), {0, 0, 0}}, world::HalfSpace{}, {}).p_WA;
  const double step = 1e-10;
  double travel = 0;
  for (double angle = -2e-6 + step; angle < 2e-6; angle += step) {
    const Distance d = calc_distance(box, {turn(angle, Vector3d(0, 1, 0)), {0, 0, 0}}, world::HalfSpace{}, {});
    EXPECT_LT((d.p_WA - last).norm(), 0.1 * step * 0.1 / level + 1e-12);  // from end to end over a slope of level / length
    travel += (d.p_WA - last).norm();
    last = d.p_WA;
  }
  EXPECT_NEAR(travel, 0.1, 1e-6);
}

TEST(BoxBox, FaceOnFaceAndPenetration_ClosedNumbers) {
  const world::Box box{{0.1, 0.1, 0.1}};
  Distance d = calc_distance(box, {turn(0.3, Vector3d::UnitZ()), {0.02, 0.01, 0.25}}, box, {});
  EXPECT_NEAR(d.phi, 0.05, 1e-12);
  expect_near(d.nhat_BA_W, {0, 0, 1}, 1e-9, "normal");
  d = calc_distance(box, {turn(0.3, Vector3d::UnitZ()), {0.02, 0.01, 0.17}}, box, {});
  EXPECT_NEAR(d.phi, -0.03, 1e-12);
  expect_near(d.nhat_BA_W, {0, 0, 1}, 1e-9, "normal");
  expect_consistent(d, "penetration");
}

TEST(CapsuleBox, DeepInside_CountsFromTheAxis) {
  const Distance d = calc_distance(world::Capsule{0.02, 0.05}, {turn(std::numbers::pi / 2, Vector3d::UnitX()), {0.01, 0.0, 0.06}},
                                   world::Box{{0.2, 0.2, 0.1}}, {});
  EXPECT_NEAR(d.phi, -0.06, 1e-12);
  expect_near(d.nhat_BA_W, {0, 0, 1}, 1e-9, "normal");
}

// --- every pair -------------------------------------------------------------------------------------------------------------

// Weak duality: for convex sets every unit n gives gap_along(n) ≤ phi, and two points of the sets that are gap_along(n) apart
// prove both optimal. In penetration the gap along n shows that the shift −phi n parts the sets, and directions all over the
// sphere show that no shorter shift does.
TEST_P(EveryPair, RandomPoses_AreOptimal) {
  const double tolerance = 1e-12;
  Random random(11);
  int apart = 0, overlapping = 0;
  for (int i = 0; i < 1500; ++i) {
    const double spread = i % 3 == 0 ? 0.03 : 0.1;
    const Pose X_WA = random.pose(spread), X_WB = random.pose(spread);
    const Distance d = calc_distance(a(), X_WA, b(), X_WB);
    const std::string what = GetParam().name() + " #" + std::to_string(i) + " phi " + std::to_string(d.phi);
    expect_consistent(d, what);
    EXPECT_LT(test::outside(a(), X_WA, d.p_WA), tolerance) << what;
    EXPECT_LT(test::outside(b(), X_WB, d.p_WB), tolerance) << what;
    Vector3d n = d.nhat_BA_W;
    if (test::is_half_space(b())) {
      expect_near(n, X_WB.R.col(2), 1e-15, what);
      n = X_WB.R.col(2);
    }
    if (test::is_half_space(a())) {
      expect_near(n, -X_WA.R.col(2), 1e-15, what);
      n = -X_WA.R.col(2);
    }
    EXPECT_NEAR(test::gap_along(a(), X_WA, b(), X_WB, n), d.phi, tolerance) << what;
    if (d.phi > 0) {
      ++apart;
    } else if (!test::is_half_space(a()) && !test::is_half_space(b())) {
      for (int k = 0; k < 300; ++k) {
        const Vector3d other = k % 2 ? random.direction() : Vector3d((n + 0.3 * random.in_cube(1)).normalized());
        EXPECT_LE(test::gap_along(a(), X_WA, b(), X_WB, other), d.phi + tolerance)
            << what << " a shorter way out along " << other.transpose();
      }
      ++overlapping;
    } else {
      ++overlapping;
    }
  }
  EXPECT_GT(apart, 100);
  EXPECT_GT(overlapping, 100);
}

TEST_P(EveryPair, Exchanged_SamePhiFlippedNormal) {
  const double tolerance = 1e-13;
  Random random(12);
  for (int i = 0; i < 300; ++i) {
    const Pose X_WA = random.pose(0.08), X_WB = random.pose(0.08);
    const Distance d = calc_distance(a(), X_WA, b(), X_WB), e = calc_distance(b(), X_WB, a(), X_WA);
    EXPECT_NEAR(d.phi, e.phi, tolerance);
    expect_near(d.nhat_BA_W, -e.nhat_BA_W, 1e-7, "normal");  // no kink within 1e-7 of 300 random poses
    expect_near(d.p_WA, e.p_WB, 1e-7, "witness");
    expect_near(d.p_WB, e.p_WA, 1e-7, "witness");
  }
}

TEST_P(EveryPair, MovedTogether_AnswerMovesAlong) {
  Random random(13);
  for (int i = 0; i < 300; ++i) {
    const Pose X_WA = random.pose(0.08), X_WB = random.pose(0.08), X_VW = random.pose(1.0);
    const Distance d = calc_distance(a(), X_WA, b(), X_WB), e = calc_distance(a(), X_VW * X_WA, b(), X_VW * X_WB);
    EXPECT_NEAR(d.phi, e.phi, 1e-13);
    expect_near(X_VW.R * d.nhat_BA_W, e.nhat_BA_W, 1e-7, "normal");
    expect_near(X_VW * d.p_WA, e.p_WA, 1e-7, "witness");
  }
}

TEST_P(EveryPair, AlongAPath_PhiIsLipschitz) {
  // |phi(t + dt) − phi(t)| ≤ ‖displacement of the farthest point‖: no jumps when features change or contact begins.
  Random random(14);
  for (int i = 0; i < 20; ++i) {
    const Pose X_WB = random.pose(0.03);
    const Vector3d from = random.in_cube(0.2), to = random.in_cube(0.2), axis = random.direction();
    const Eigen::Matrix3d R = random.rotation();
    const int steps = 500;
    double last = 0;
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      const Pose X_WA{R * turn(2.0 * t, axis), from + t * (to - from)};
      const double phi = calc_distance(a(), X_WA, b(), X_WB).phi;
      const double most = ((to - from).norm() + 2.0 * 0.3) / steps;  // no point of a bounded shape here is 0.3 m from its origin
      if (k > 0 && !test::is_half_space(a())) {
        EXPECT_LE(std::abs(phi - last), most + 1e-12);
      }
      last = phi;
    }
  }
}

TEST_P(EveryPair, AlignedAndCoincident_NeverNaN) {
  std::vector<Eigen::Matrix3d> turns{Eigen::Matrix3d::Identity()};
  for (int k = 0; k < 3; ++k) turns.push_back(turn(std::numbers::pi / 2, Vector3d::Unit(k)));
  turns.push_back(turn(std::numbers::pi, Vector3d::UnitX()));
  for (const auto& R : turns) {
    for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(0, 0, 0.1), Vector3d(0, 0.05, 0), Vector3d(0.2, 0, 0), Vector3d(1e-9, 0, 0),
                              Vector3d(0.3, 0.3, 0.3)}) {
      const Distance d = calc_distance(a(), {R, p}, b(), {});
      const std::string what = GetParam().name();
      expect_consistent(d, what);
      if (!test::is_half_space(a()) && !test::is_half_space(b())) {
        EXPECT_NEAR(test::gap_along(a(), {R, p}, b(), {}, d.nhat_BA_W), d.phi, 1e-8) << what << " at " << p.transpose();
      }
    }
  }
}

TEST_P(EveryPair, Repeated_SameBits) {
  Random random(15);
  for (int i = 0; i < 50; ++i) {
    const Pose X_WA = random.pose(0.08), X_WB = random.pose(0.08);
    const Distance d = calc_distance(a(), X_WA, b(), X_WB), e = calc_distance(a(), X_WA, b(), X_WB);
    EXPECT_EQ(d.phi, e.phi);
    EXPECT_EQ(d.p_WA, e.p_WA);
    EXPECT_EQ(d.p_WB, e.p_WB);
    EXPECT_EQ(d.nhat_BA_W, e.nhat_BA_W);
  }
}

TEST(Sphere, PathThroughABoxCorner_NormalIsContinuousOutside) {
  // Around a convex feature the normal of a sphere turns continuously: by no more than the step over the distance.
  const double step = 1e-4;
  for (const auto& s : test::all_shapes()) {
    Vector3d last;
    bool first = true;
    for (double y = -0.2; y < 0.2; y += step) {
      const Vector3d p(0.11, y, 0.13);
      const Distance d = calc_distance(world::Sphere{0.01}, {Eigen::Matrix3d::Identity(), p}, s.shape, {});
      const double away = d.phi + 0.01;
      if (!first) {
        EXPECT_LE((d.nhat_BA_W - last).norm(), 1.01 * step / away + 1e-12) << s.name;
      }
      last = d.nhat_BA_W;
      first = false;
    }
  }
}

TEST(Shapes, TwoHalfSpaces_Refused) {
  try {
    (void)calc_distance(world::HalfSpace{}, {}, world::HalfSpace{}, {});
    FAIL();
  } catch (const core::InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find("two half-spaces"), std::string::npos) << e.what();
  }
}

// Of a mesh that comes after another one where that was in memory as well.
TEST(Shapes, DataOfAMesh_IsMadeOnceAndNeverThatOfAnotherOne) {
  for (int i = 1; i <= 20; ++i) {
    const Vector3d half = 0.01 * i * Vector3d::Ones();
    const world::Shape shape = test::make_box_mesh(half);
    const detail::ShapeData data = detail::find_shape_data(shape), again = detail::find_shape_data(shape);
    EXPECT_NEAR(data.bounding_radius, half.norm(), 1e-15);
    EXPECT_EQ(data.mesh, again.mesh);
    EXPECT_EQ(data.polytope, again.polytope);
    EXPECT_NE(data.mesh, detail::find_shape_data(test::make_box_mesh(half)).mesh);
  }
}

TEST(Shapes, MeshWithIndexOutOfRange_Refused) {
  auto mesh = std::make_shared<world::ConvexMesh>(*test::make_mesh().mesh);
  mesh->triangles(1, 3) = 6;
  try {
    (void)calc_distance(world::Sphere{0.1}, {}, world::Mesh{mesh}, {});
    FAIL();
  } catch (const core::InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find("mesh.triangles[3]"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace stiction::contact
