#include "stiction/sensing/surface.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <utility>

#include "sensing/robots.hpp"
#include "stiction/sensing/tessellate.hpp"
#include "stiction/world/triangle.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

Vector3d random_vector(core::Random& random, double scale) { return scale * Vector3d(random.normal(), random.normal(), random.normal()); }

Matrix3Xd random_triangles(core::Random& random, int n) {
  Matrix3Xd out(3, 3 * n);
  for (int t = 0; t < n; ++t) {
    const Vector3d center = random_vector(random, 1);
    for (int k = 0; k < 3; ++k) out.col(3 * t + k) = center + random_vector(random, 0.2);
  }
  return out;
}

TEST(TriangleTree, ClosestPoint_IsThatOfAllTriangles) {
  core::Random random(1, 0);
  for (const int n : {1, 2, 3, 4, 5, 8, 9, 17, 500}) {
    const Matrix3Xd corners = random_triangles(random, n);
    const TriangleTree tree(corners);
    for (int i = 0; i < 500; ++i) {
      const Vector3d p = random_vector(random, 1.5);
      double least = std::numeric_limits<double>::infinity();
      for (int t = 0; t < n; ++t)
        least = std::min(
            least, (world::nearest_on_triangle(p, corners.col(3 * t), corners.col(3 * t + 1), corners.col(3 * t + 2)) - p).squaredNorm());
      const TriangleTree::Closest found = tree.closest(p);
      EXPECT_EQ(found.squared_distance, least);
      EXPECT_EQ(tree.closest(p, random.index(n)).squared_distance, least) << "a guess changes no distance";
      EXPECT_EQ((found.point - p).squaredNorm(), least);
    }
  }
  EXPECT_EQ(TriangleTree(Matrix3Xd(3, 0)).closest(Vector3d::Zero()).triangle, -1);
}

TEST(TriangleTree, RayInThePlaneOfABoxSide_IsNotLost) {
  // Rows of triangles between z = 0 and 1: their boxes begin and end where rays along x pass.
  Matrix3Xd corners(3, 3 * 40);
  for (int t = 0; t < 40; ++t) corners.middleCols<3>(3 * t) << t, t, t, 0, 2, 0, 0, 0, 1;
  const TriangleTree tree(corners);
  for (const double sign : {1.0, -1.0})
    for (const auto& [y, z] : {std::pair{0.5, 0.0}, {0.0, 0.5}, {0.0, 1.0}, {2.0, 0.0}})
      for (const double zero : {0.0, -0.0})
        EXPECT_TRUE(tree.is_hit(Vector3d(sign > 0 ? -1 : 41, y, z), Vector3d(sign, zero, zero))) << sign << " at " << y << ", " << z;
  EXPECT_FALSE(tree.is_hit(Vector3d(-1, 0.5, 1.1), Vector3d(1, 0, 0)));
}

TEST(TriangleTree, ClosestOnTriangle_SatisfiesTheVariationalInequality) {
  core::Random random(2, 0);
  for (int i = 0; i < 2000; ++i) {
    const Matrix3Xd T = random_triangles(random, 1);
    const Vector3d p = random_vector(random, 1), x = world::nearest_on_triangle(p, T.col(0), T.col(1), T.col(2));
    for (int k = 0; k < 3; ++k) EXPECT_LE((p - x).dot(T.col(k) - x), 1e-12);  // no corner lies on p's side of x
    const Eigen::Vector3d weights = (Eigen::Matrix4d() << T, Vector3d::Zero(), 1, 1, 1, 0)
                                        .finished()
                                        .leftCols<3>()
                                        .colPivHouseholderQr()
                                        .solve((Eigen::Vector4d() << x, 1).finished());
    EXPECT_GE(weights.minCoeff(), -1e-9);
    EXPECT_NEAR((T * weights - x).norm(), 0, 1e-9);
  }
}

TEST(TriangleTree, Ray_HitsWhereOneOfTheTrianglesIsHit) {
  core::Random random(3, 0);
  const Matrix3Xd corners = random_triangles(random, 200);
  const TriangleTree tree(corners);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p = random_vector(random, 2), d = random_vector(random, 1);
    bool expected = false;
    for (int t = 0; t < 200; ++t) {  // by the signs of three volumes
      const Vector3d a = corners.col(3 * t) - p, b = corners.col(3 * t + 1) - p, c = corners.col(3 * t + 2) - p;
      const double u = d.dot(b.cross(c)), v = d.dot(c.cross(a)), w = d.dot(a.cross(b));
      const bool inside = (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
      expected |= inside && (u * a + v * b + w * c).dot(d) / (u + v + w) > 0;
    }
    EXPECT_EQ(tree.is_hit(p, d), expected) << "ray " << i;
    hits += expected;
  }
  EXPECT_GT(hits, 100);
  EXPECT_LT(hits, 1900);
}

double total_area(const Matrix3Xd& corners) {
  double out = 0;
  for (Eigen::Index t = 0; t < corners.cols(); t += 3)
    out += 0.5 * Vector3d(corners.col(t + 1) - corners.col(t)).cross(Vector3d(corners.col(t + 2) - corners.col(t))).norm();
  return out;
}

TEST(Tessellation, RoundShapes_HaveTheirAreaAndWindOutwards) {
  const double pi = std::numbers::pi;
  const struct {
    world::Shape shape;
    double area;
  } cases[] = {{world::Sphere{0.1}, 4 * pi * 0.01},
               {world::Capsule{0.1, 0.2}, 4 * pi * 0.01 + 2 * pi * 0.1 * 0.4},
               {world::Cylinder{0.1, 0.2}, 2 * pi * 0.01 + 2 * pi * 0.1 * 0.4},
               {world::Box{{0.1, 0.2, 0.3}}, 8 * (0.02 + 0.03 + 0.06)}};
  for (const auto& c : cases) {
    const Matrix3Xd corners = tessellate(c.shape, 64);
    // Chords of 64 segments: 1 − cos(π/64) = 0.12 % shorter.
    EXPECT_LE(total_area(corners), c.area * (1 + 1e-12));
    EXPECT_GE(total_area(corners), c.area * (1 - 4 * (1 - std::cos(pi / 64))));
    double volume = 0;
    for (Eigen::Index t = 0; t < corners.cols(); t += 3) {
      const Eigen::Matrix3d T = corners.middleCols<3>(t);
      EXPECT_GT(T.determinant(), 0) << "each triangle is seen from outside of a convex body around the origin";
      volume += T.determinant() / 6;
    }
    EXPECT_GT(volume, 0.98 * c.area / 3 * 0.1);
  }
}

/// A link of two boxes that overlap in the middle third: 1 × 1 × 2 from z = 0 to 2 and from z = 1 to 3, split at z = 1 and 2 by nobody.
constexpr const char* kTwoBoxes = R"(<robot name="r"><link name="base"/>
<link name="arm">
  <collision name="a"><origin xyz="0 0 0.1"/><geometry><box size="0.1 0.1 0.2"/></geometry></collision>
  <collision name="b"><origin xyz="0 0 0.15"/><geometry><box size="0.06 0.06 0.06"/></geometry></collision>
</link>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>)";

TEST(Surface, BoxInsideABox_IsTrimmed) {
  const auto model = make_robot(kTwoBoxes);
  const std::array<int, 1> arm{body_index(*model, "robot/arm")};
  const Surfaces trimmed = make_surfaces(*model, arm, {});
  EXPECT_EQ(trimmed.links[0].tree.size(), 12) << "six faces of the outer box";
  EXPECT_NEAR(trimmed.links[0].area, 2 * 0.01 + 4 * 0.02, 1e-12);
  ASSERT_EQ(trimmed.notes.size(), 1u);
  EXPECT_EQ(trimmed.notes[0], "robot/arm: of 24 triangles 12 are left out as hidden and 0 as flat, 0 are turned around");
  SurfaceOptions whole;
  whole.rays = 0;
  EXPECT_EQ(make_surfaces(*model, arm, whole).links[0].tree.size(), 24);
}

TEST(Surface, Normals_AreOutwardAndSharpEdgesStaySharp) {
  const auto model = make_robot(kTwoBoxes);
  const std::array<int, 1> arm{body_index(*model, "robot/arm")};
  const Surface box = make_surfaces(*model, arm, {}).links[0];
  for (const SurfacePoint& s : sample_surface(box, 200, Sampling::Uniform, 0)) {
    const Vector3d flat = box.normal(s.triangle, s.p_L, Normals::Flat);
    EXPECT_NEAR((flat - box.normal(s.triangle, s.p_L, Normals::Smooth)).norm(), 0, 1e-12);
    EXPECT_NEAR(flat.dot(s.p_L - Vector3d(0, 0, 0.1)), std::abs(flat.z()) > 0.5 ? 0.1 : 0.05, 1e-12);
  }
}

TEST(Surface, SmoothNormals_OfASphereAreRadial) {
  const auto model = make_robot(R"(<robot name="r"><link name="base"/>
<link name="arm"><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint></robot>)");
  const std::array<int, 1> arm{body_index(*model, "robot/arm")};
  const Surface ball = make_surfaces(*model, arm, {}).links[0];
  double flat = 0, smooth = 0;
  for (const SurfacePoint& s : sample_surface(ball, 500, Sampling::Stratified, 0)) {
    flat = std::max(flat, (ball.normal(s.triangle, s.p_L, Normals::Flat) - s.p_L.normalized()).norm());
    smooth = std::max(smooth, (ball.normal(s.triangle, s.p_L, Normals::Smooth) - s.p_L.normalized()).norm());
  }
  EXPECT_LT(flat, 2 * std::numbers::pi / 32);  // half a segment in each direction
  EXPECT_LT(smooth, 0.25 * flat);
}

TEST(Surface, Samples_AreUniformByAreaAndTheSameForASeed) {
  const auto model = make_robot(kTwoBoxes);
  const std::array<int, 1> arm{body_index(*model, "robot/arm")};
  const Surface box = make_surfaces(*model, arm, {}).links[0];
  for (const Sampling sampling : {Sampling::Uniform, Sampling::Stratified, Sampling::BlueNoise}) {
    const auto samples = sample_surface(box, 10000, sampling, 7), again = sample_surface(box, 10000, sampling, 7);
    int top = 0;
    Vector3d mean = Vector3d::Zero();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      EXPECT_EQ(samples[i].p_L, again[i].p_L);
      top += samples[i].p_L.z() > 0.2 - 1e-12;
      mean += samples[i].p_L / 10000;
    }
    EXPECT_NEAR(top, 1000, 4 * std::sqrt(900.0));  // a tenth of the area, four standard deviations
    EXPECT_NEAR((mean - Vector3d(0, 0, 0.1)).norm(), 0, 4 * 0.1 / 100);
  }
}

TEST(Surface, BlueNoise_LiesFartherApart) {
  const auto model = make_robot(kTwoBoxes);
  const std::array<int, 1> arm{body_index(*model, "robot/arm")};
  const Surface box = make_surfaces(*model, arm, {}).links[0];
  const auto least = [&](Sampling sampling) {
    const auto samples = sample_surface(box, 300, sampling, 3);
    EXPECT_EQ(samples.size(), 300u);
    double out = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < samples.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) out = std::min(out, (samples[i].p_L - samples[j].p_L).norm());
    return out;
  };
  const double densest = 2 * std::sqrt(box.area / (2 * std::sqrt(3.0) * 300));  // distance in a hexagonal packing of discs
  EXPECT_GT(least(Sampling::BlueNoise), 0.6 * densest);
  EXPECT_LT(least(Sampling::Stratified), 0.3 * densest);
}

TEST(Surface, MeshesOfArms_AreThoseOfTheirFilesWithoutHiddenFaces) {
  const auto model = make_arm(kUr5);
  const std::array<int, 1> forearm{body_index(*model, "arm/forearm_link")};
  SurfaceOptions whole;
  whole.rays = 0;
  EXPECT_EQ(make_surfaces(*model, forearm, whole).links[0].tree.size(), 1050) << "triangles of the STL file, not of its hull";
  const Surface trimmed = make_surfaces(*model, forearm, {}).links[0];
  EXPECT_LT(trimmed.tree.size(), 1050);
  EXPECT_GT(trimmed.tree.size(), 500);
}

TEST(Surface, CachedFaces_AreThoseThatAreSeen) {
  const auto model = make_robot(kTwoBoxes);
  const std::array<int, 1> arm{body_index(*model, "robot/arm")};
  const std::filesystem::path folder = stiction::test::folder_of_the_process() / "faces";
  SurfaceOptions kept;
  kept.cache_dir = folder;
  const auto is_fresh = [&] {
    return make_surfaces(*model, arm, kept).links[0].tree.corners() == make_surfaces(*model, arm, {}).links[0].tree.corners();
  };
  EXPECT_TRUE(is_fresh()) << "written";
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_TRUE(is_fresh()) << "read";
  std::ofstream(files[0]) << "damaged";
  EXPECT_TRUE(is_fresh()) << "found anew";
  EXPECT_GT(std::filesystem::file_size(files[0]), 24u) << "and written again";
  std::filesystem::remove_all(folder);
}

TEST(Surface, OpenMesh_IsNamedAndUsed) {
  const std::filesystem::path file = stiction::test::folder_of_the_process() / "open.obj";
  std::ofstream(file)
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 0.5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 2 5\n";  // a tetrahedron without a face, and no triangle
  const auto model =
      make_robot(R"(<robot name="r"><link name="base"/><link name="arm"><collision><geometry><mesh filename=")" + file.string() +
                 R"("/></geometry></collision></link>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint></robot>)");
  const std::array<int, 1> arm{body_index(*model, "robot/arm")};
  const Surfaces surfaces = make_surfaces(*model, arm, {});
  EXPECT_EQ(surfaces.links[0].tree.size(), 3);
  ASSERT_EQ(surfaces.notes.size(), 2u);
  EXPECT_EQ(surfaces.notes[0], "robot/arm: of 4 triangles 0 are left out as hidden and 1 as flat, 0 are turned around");
  EXPECT_EQ(surfaces.notes[1], "robot/arm: 3 edges do not border two triangles: its surface is open or folded, and is used as it is");
  std::filesystem::remove(file);
}

TEST(Surface, LinkWithoutGeometry_IsRefused) {
  const auto model = make_robot(kTwoBoxes);
  const std::array<int, 1> base{body_index(*model, "robot/base")};
  EXPECT_EQ(stiction::test::message_of([&] { make_surfaces(*model, base, {}); }),
            "links: got 'robot/base', of whose 0 triangles 0 are hidden, expected links with a surface that can be touched");
}

}  // namespace
}  // namespace stiction::sensing::test
