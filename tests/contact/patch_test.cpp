// Patches: known polygons, completeness and truth of the points, continuity, ids, planar models, no heap use.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <map>
#include <numbers>

#include "contact/scenes.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::contact {
namespace {

using test::Fixture;
using test::Random;
using test::turn;
using test::Vector3d;
using world::Pose;

constexpr double kPi = std::numbers::pi;

/// A free object over a fixed one; contacts within 1 m unless told.
struct Two : Fixture {
  Two(const world::Shape& a, const world::Shape& b, const Pose& X_WB = {}, world::ObjectJoint joint = world::ObjectJoint::Free)
      : Fixture(make(a, b, X_WB, joint)) {}

  static world::Scene make(const world::Shape& a, const world::Shape& b, const Pose& X_WB, world::ObjectJoint joint) {
    world::Scene scene;
    scene.contact_distance = 1;
    scene.objects = {test::make_object("a", a, joint)};
    scene.fixed = {{"b", X_WB, {{"g", b, {}, 1.0}}}};
    return scene;
  }

  std::vector<Contact> at(const Eigen::Matrix3d& R, const Vector3d& p, double cutoff = 0.02) {
    Eigen::VectorXd free = model->neutral();
    const Eigen::Quaterniond quaternion(R);
    free << p, quaternion.coeffs();
    move_to(free);
    return query_contacts({.cutoff = cutoff});
  }
};

/// Every wanted point is the place of one contact, and the other way round.
void expect_points(const std::vector<Contact>& contacts, std::vector<Vector3d> want, double tolerance) {
  ASSERT_EQ(contacts.size(), want.size());
  for (const Contact& c : contacts) {
    const auto it = std::find_if(want.begin(), want.end(), [&](const Vector3d& p) { return (p - c.p_WB).norm() <= tolerance; });
    ASSERT_NE(it, want.end()) << "no corner at " << c.p_WB.transpose();
    want.erase(it);
  }
}

const world::Box kSmall{{0.05, 0.03, 0.02}};
const world::Box kLarge{{0.2, 0.15, 0.1}};

TEST(Patch, BoxOnLargerBox_FourCornersOfTheSmallerFace) {
  Two s(kSmall, kLarge);
  for (const double gap : {-5e-3, -1e-9, 0.0, 1e-12, 1e-9, 1e-3}) {
    for (const double angle : {0.0, 1e-9, kPi / 6, kPi / 4, 2.0}) {
      const auto contacts = s.at(turn(angle), {0.01, 0.02, 0.12 + gap});
      std::vector<Vector3d> corners;
      for (const double x : {-0.05, 0.05}) {
        for (const double y : {-0.03, 0.03}) corners.push_back(turn(angle) * Vector3d(x, y, 0) + Vector3d(0.01, 0.02, 0.1));
      }
      expect_points(contacts, corners, 1e-12);
      for (const Contact& c : contacts) {
        EXPECT_NEAR(c.phi, gap, 1e-15);
        EXPECT_LE((c.nhat_BA_W - Vector3d::UnitZ()).norm(), 1e-15);
        EXPECT_EQ(c.reference, PatchSide::B);
        EXPECT_EQ(c.kind, PatchPoint::Vertex);
      }
    }
  }
}

TEST(Patch, EqualSquaresTurned45Degrees_Octagon) {
  Two s(world::Box{{0.1, 0.1, 0.1}}, world::Box{{0.1, 0.1, 0.1}});
  const auto contacts = s.at(turn(kPi / 4), {0, 0, 0.2});
  std::vector<Vector3d> corners;
  const double t = 0.1 * (std::numbers::sqrt2 - 1);
  for (const double a : {-0.1, 0.1}) {
    for (const double b : {-t, t}) {
      corners.emplace_back(a, b, 0.1);
      corners.emplace_back(b, a, 0.1);
    }
  }
  expect_points(contacts, corners, 1e-6);  // side planes stand out by 1e-6 of the size
  for (const Contact& c : contacts) {
    EXPECT_EQ(c.kind, PatchPoint::Crossing);
    EXPECT_NEAR(c.edge_W.norm(), 1, 1e-12);
    EXPECT_NEAR(c.side_W.norm(), 1, 1e-12);
    EXPECT_NEAR(c.side_W.z(), 0, 1e-12);
  }
}

TEST(Patch, LargeBoxOnSmallOne_CornersOfTheLowerFace) {
  Two s(kLarge, kSmall);
  const auto contacts = s.at(turn(kPi / 6), {0.01, 0.02, 0.12});
  expect_points(contacts, {{0.05, 0.03, 0.02}, {-0.05, 0.03, 0.02}, {0.05, -0.03, 0.02}, {-0.05, -0.03, 0.02}}, 1e-6);
  for (const Contact& c : contacts) EXPECT_EQ(c.kind, PatchPoint::Corner);
}

TEST(Patch, BoxHalfOverAnEdge_MixedCorners) {
  Two s(kSmall, kLarge);
  const auto contacts = s.at(turn(0), {0.2, 0, 0.12});
  expect_points(contacts, {{0.15, 0.03, 0.1}, {0.15, -0.03, 0.1}, {0.2, 0.03, 0.1}, {0.2, -0.03, 0.1}}, 1e-6);
  int crossings = 0;
  for (const Contact& c : contacts) crossings += c.kind == PatchPoint::Crossing;
  EXPECT_EQ(crossings, 2);
}

TEST(Patch, EqualBoxesExactlyAboveEachOther_FourPointsWithTheSameIdsUnderNoise) {
  Two s(kSmall, kSmall);
  std::vector<std::uint64_t> ids;
  for (const Contact& c : s.at(turn(0), {0, 0, 0.04})) ids.push_back(c.id);
  ASSERT_EQ(ids.size(), 4u);
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const auto contacts = s.at(turn(random.uniform(0, 1e-8), random.direction()), Vector3d(0, 0, 0.04) + random.in_cube(1e-9));
    std::vector<std::uint64_t> now;
    for (const Contact& c : contacts) now.push_back(c.id);
    EXPECT_EQ(now, ids);
  }
}

TEST(Patch, HalfSpace_LowestFaceOfEveryShape) {
  const auto count = [](const world::Shape& shape, const Eigen::Matrix3d& R, double height) {
    Two s(shape, world::HalfSpace{});
    return s.at(R, {0, 0, height}, 1e-6).size();
  };
  EXPECT_EQ(count(world::Box{{0.1, 0.2, 0.3}}, turn(0), 0.3), 4u);
  EXPECT_EQ(count(world::Box{{0.1, 0.1, 0.1}}, turn(kPi / 4, Vector3d::UnitX()), 0.1 * std::numbers::sqrt2), 2u);
  EXPECT_EQ(count(test::make_box_mesh({0.1, 0.2, 0.3}), turn(0), 0.3), 4u);
  EXPECT_EQ(count(world::Capsule{0.05, 0.1}, turn(kPi / 2, Vector3d::UnitX()), 0.05), 2u);
  EXPECT_EQ(count(world::Capsule{0.05, 0.1}, turn(0), 0.15), 1u);
  EXPECT_EQ(count(world::Cylinder{0.05, 0.1}, turn(kPi / 2, Vector3d::UnitX()), 0.05), 2u);
  EXPECT_EQ(count(world::Cylinder{0.05, 0.1}, turn(0), 0.1), 7u);  // six on the cap and the lowest of the rim
  EXPECT_EQ(count(test::make_mesh(), turn(0.3), 0.06), 1u);
}

TEST(Patch, PlanarModel_TwoPointsInThePlane) {
  for (const world::Shape& floor :
       {world::Shape{kLarge}, world::Shape{test::make_box_mesh({0.2, 0.15, 0.1})}, world::Shape{world::HalfSpace{}}}) {
    const double top = std::holds_alternative<world::HalfSpace>(floor) ? 0.0 : 0.1;
    for (const world::Shape& shape : {world::Shape{kSmall}, world::Shape{test::make_box_mesh(kSmall.half_extents)}}) {
      Two s(shape, floor, {}, world::ObjectJoint::PlanarXZ);
      ASSERT_EQ(s.model->planar_axis(), 1);
      s.move_to(Eigen::Vector3d(0.01, top + 0.02, 0));
      const auto contacts = s.query_contacts({.cutoff = 0.01});
      expect_points(contacts, {{-0.04, 0, top}, {0.06, 0, top}}, 1e-6);  // the slack of side planes
      for (const Contact& c : contacts) {
        EXPECT_NEAR(c.phi, 0, 1e-12);
        EXPECT_LE((c.nhat_BA_W - Vector3d::UnitZ()).norm(), 1e-12);
      }
    }
  }
}

/// Points spread evenly over a sphere, and their hull.
world::Mesh make_round_mesh(int n, double radius) {
  Eigen::Matrix3Xd points(3, n);
  for (int i = 0; i < n; ++i) {
    const double z = 1 - (2.0 * i + 1) / n, angle = kPi * (3 - std::sqrt(5.0)) * i, r = std::sqrt(1 - z * z);
    points.col(i) = radius * Vector3d(r * std::cos(angle), r * std::sin(angle), z);
  }
  return {std::make_shared<const world::ConvexMesh>(world::make_convex_hull(points))};
}

TEST(Patch, PlanarModelRoundMeshesOfAnySize_AtMostThreePoints) {
  for (const int n : {20, 100, 257, 642, 2000}) {  // more than 256 vertices: codes of features coincide
    for (const world::ObjectJoint joint : {world::ObjectJoint::Slider, world::ObjectJoint::PlanarXZ}) {
      const double radius = 0.1, height = 5;
      Two s(make_round_mesh(n, radius), world::HalfSpace{}, {Eigen::Matrix3d::Identity(), {0, 0, -height}}, joint);
      ASSERT_TRUE(s.model->planar_axis().has_value());
      s.move_to(s.model->neutral());
      const auto contacts = s.query_contacts({.margin = 2 * height});
      ASSERT_GE(contacts.size(), 1u) << n;
      EXPECT_LE(contacts.size(), 3u) << n;
      double lowest = std::numeric_limits<double>::infinity(), want = lowest;
      for (const Contact& c : contacts) lowest = std::min(lowest, c.phi);
      const auto& mesh = *std::get<world::Mesh>(s.model->geometries()[0].shape).mesh;
      for (const auto& v : mesh.vertices.colwise()) want = std::min(want, height + v.z());
      EXPECT_NEAR(lowest, want, 1e-12 * height) << n;
      for (std::size_t i = 1; i < contacts.size(); ++i) EXPECT_LT(contacts[i - 1].id, contacts[i].id) << n;
    }
  }
}

world::Mesh make_prism(int sides, double radius, double half) {
  Eigen::Matrix3Xd points(3, 2 * sides);
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * kPi * i / sides;
    points.col(2 * i) = Vector3d(radius * std::cos(angle), radius * std::sin(angle), -half);
    points.col(2 * i + 1) = Vector3d(radius * std::cos(angle), radius * std::sin(angle), half);
  }
  auto mesh = std::make_shared<world::ConvexMesh>();
  mesh->vertices = points;
  std::vector<Eigen::Vector3i> triangles;
  for (int i = 0; i < sides; ++i) {
    const int j = (i + 1) % sides;
    triangles.emplace_back(2 * i, 2 * j, 2 * i + 1);
    triangles.emplace_back(2 * j, 2 * j + 1, 2 * i + 1);
    if (i > 0 && j > 0) {
      triangles.emplace_back(0, 2 * j, 2 * i);
      triangles.emplace_back(1, 2 * i + 1, 2 * j + 1);
    }
  }
  mesh->triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) mesh->triangles.col(static_cast<Eigen::Index>(t)) = triangles[t];
  return {mesh};
}

TEST(Patch, FaceOfManyCorners_EightSpreadOnes) {
  const world::Mesh prism = make_prism(64, 0.05, 0.03);
  for (const world::Shape& floor :
       {world::Shape{world::HalfSpace{}}, world::Shape{kLarge}, world::Shape{test::make_box_mesh({0.2, 0.2, 0.1})}}) {
    const double top = std::holds_alternative<world::HalfSpace>(floor) ? 0 : 0.1;
    Two s(prism, floor);
    const auto contacts = s.at(turn(0.1), {0, 0, top + 0.03});
    ASSERT_EQ(contacts.size(), 8u);
    for (int k = 0; k < 16; ++k) {
      const Vector3d direction = turn(kPi / 8 * k) * Vector3d::UnitX();
      double reach = 0;
      for (const Contact& c : contacts) reach = std::max(reach, direction.dot(c.p_WB));
      EXPECT_GE(reach, 0.8 * 0.05);
    }
  }
}

/// Pairs whose surfaces a patch may describe, by what the test knows of them: gap_along and outside.
struct PatchPair {
  std::string name;
  world::Shape a, b;
};

std::vector<PatchPair> pair_cases() {
  std::vector<PatchPair> out;
  const std::vector<test::Named> a = {{"box", kSmall},
                                      {"box_mesh", test::make_box_mesh({0.05, 0.03, 0.02})},
                                      {"octahedron", test::make_mesh()},
                                      {"cylinder", world::Cylinder{0.04, 0.03}},
                                      {"capsule", world::Capsule{0.02, 0.05}}};
  const std::vector<test::Named> b = {{"box", world::Box{{0.06, 0.04, 0.03}}},
                                      {"box_mesh", test::make_box_mesh({0.06, 0.04, 0.03})},
                                      {"cylinder", world::Cylinder{0.05, 0.03}},
                                      {"prism", make_prism(12, 0.05, 0.03)},
                                      {"half_space", world::HalfSpace{}}};
  for (const auto& i : a) {
    for (const auto& j : b) out.push_back({i.name + "_" + j.name, i.shape, j.shape});
  }
  return out;
}

void PrintTo(const PatchPair& pair, std::ostream* out) { *out << pair.name; }

class PatchOfPair : public ::testing::TestWithParam<PatchPair> {};
INSTANTIATE_TEST_SUITE_P(Pairs, PatchOfPair, ::testing::ValuesIn(pair_cases()), [](const auto& p) { return p.param.name; });

/// A pose of A with its support along `down` at a height over the top of B: nearly flat on it, near its edge or anywhere.
Pose make_pose(Random& random, const PatchPair& pair, int i) {
  const Vector3d axes[] = {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
  const Eigen::Matrix3d face = Eigen::Quaterniond::FromTwoVectors(axes[i % 3], Vector3d::UnitZ()).toRotationMatrix();
  const double tilt = std::pow(10.0, random.uniform(-10, -0.3));
  Pose X{turn(tilt, random.direction()) * turn(random.uniform(-kPi, kPi)) * face,
         Vector3d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 0)};
  const double top = test::is_half_space(pair.b) ? 0.0 : 0.03;
  const double gaps[] = {-2e-3, -1e-6, 0.0, 1e-9, 1e-4, 5e-3};
  X.p.z() = top + test::support(pair.a, {X.R, Vector3d::Zero()}, -Vector3d::UnitZ()) + gaps[(i / 3) % 6];
  return X;
}

TEST_P(PatchOfPair, AnyPose_DeepestPointIsTheDistanceAndAllPointsAreTrue) {
  const PatchPair& pair = GetParam();
  Two s(pair.a, pair.b);
  Random random(3);
  int several = 0;
  for (int i = 0; i < 3000; ++i) {
    const Pose X = make_pose(random, pair, i);
    const auto contacts = s.at(X.R, X.p, 0.02);
    const Pose X_WA = s.X_WG(s.model->pairs()[0].geometry_a);
    const Distance d = s.distance(0);
    ASSERT_EQ(contacts.empty(), d.phi >= 0.02) << i;
    if (contacts.empty()) continue;
    several += contacts.size() > 1;
    EXPECT_LE(contacts.size(), 8u);
    // Every normal bounds the distance from below, and where they are apart two points of the bodies bound it from above.
    double phi = d.phi < 0 ? d.phi : test::gap_along(pair.a, X_WA, pair.b, {}, d.nhat_BA_W);
    for (const Contact& c : contacts) phi = std::max(phi, test::gap_along(pair.a, X_WA, pair.b, {}, c.nhat_BA_W));
    const auto nearest =
        std::min_element(contacts.begin(), contacts.end(), [](const Contact& p, const Contact& q) { return p.phi < q.phi; });
    EXPECT_LE(nearest->phi, phi + 2e-9) << i;
    EXPECT_GE(nearest->phi, phi - 2e-9) << i;
    std::uint64_t last = 0;
    for (const Contact& c : contacts) {
      EXPECT_TRUE(c.id > last || &c == &contacts.front()) << "order of ids, each once " << i;
      last = c.id;
      EXPECT_LE((c.p_WA - c.p_WB - c.phi * c.nhat_BA_W).norm(), 1e-12) << i;
      EXPECT_NEAR(c.nhat_BA_W.norm(), 1, 1e-12);
      EXPECT_LT(c.phi, 0.02);
      // Points of the two bodies stick out by no more than the slack of the side planes and the level of a rim.
      if (c.reference != PatchSide::None) {
        EXPECT_LE(test::outside(pair.a, X_WA, c.p_WA), 1e-7) << i << " A " << c.id;
        EXPECT_LE(test::outside(pair.b, {}, c.p_WB), 1e-7) << i << " B " << c.id;
      }
      if (phi > 1e-6) {
        EXPECT_GE(c.phi, phi - 2e-9) << i;
      }
    }
  }
  EXPECT_GT(several, pair.name == "octahedron_half_space" ? 0 : 300);
}

}  // namespace
}  // namespace stiction::contact
