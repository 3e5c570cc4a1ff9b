// Convex parts of meshes that are not convex: against the surface and volume they come from, in scenes, and from the cache.
#include "stiction/world/decomposition.hpp"

#include <Eigen/Geometry>

#include "stiction/contact/contact.hpp"
#include "stiction/world/cache_file.hpp"
#include "stiction/world/call_coacd.hpp"
#include "stiction/world/model.hpp"
#include "stiction/world/shapes.hpp"
#include "support/message_of.hpp"
#include "world/convex_parts.hpp"
#include "world/mesh_files.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using stiction::test::message_of;
using test::outside;
using test::surface_gap;
using test::volume_of;
using Decompose = test::MeshFiles;

const MeshOptions kDecompose{NonConvex::Decompose, {}};

bool same(const std::vector<ConvexMesh>& a, const std::vector<ConvexMesh>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const ConvexMesh& x, const ConvexMesh& y) {
    return x.vertices.cols() == y.vertices.cols() && x.vertices == y.vertices && x.triangles.cols() == y.triangles.cols() &&
           x.triangles == y.triangles;
  });
}

TEST_F(Decompose, LPrism_IsTwoBoxes) {
  const test::ObjMesh mesh = test::make_l_prism();
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const auto parts = load_mesh(write("l.obj", mesh.text()), Vector3d::Ones(), kDecompose).parts;
  EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "") << "the library prints nothing";
  EXPECT_EQ(parts.size(), 2u);
  EXPECT_NEAR(volume_of(parts), 3, 0.01);
  EXPECT_LT(surface_gap(parts, mesh), 2e-4);
  EXPECT_GT(outside(parts, {1.01, 1.01, 0.5}), 0) << "the notch is empty";
  for (const Vector3d& corner : mesh.vertices) {
    bool found = false;
    for (const auto& part : parts) found = found || (part.vertices.colwise() - corner).colwise().norm().minCoeff() == 0;
    EXPECT_TRUE(found) << "corner " << corner.transpose() << " stays where it was";
  }
  EXPECT_EQ(parts[0].source, (dir_ / "l.obj").string());
}

TEST_F(Decompose, Ring_KeepsItsSurfaceVolumeAndHole) {
  const test::ObjMesh mesh = test::make_ring(12, 6);
  const auto parts = load_mesh(write("ring.obj", mesh.text()), Vector3d::Ones(), kDecompose).parts;
  EXPECT_GE(parts.size(), 4u);
  EXPECT_LE(parts.size(), 16u);
  EXPECT_NEAR(volume_of(parts), mesh.volume(), 0.06 * mesh.volume());
  EXPECT_LT(surface_gap(parts, mesh), 0.05 * 1.3);
  EXPECT_GT(outside(parts, Vector3d::Zero()), 0.5) << "the hole is open";
  RecordProperty("volume", std::to_string(volume_of(parts) / mesh.volume()));
  RecordProperty("gap", std::to_string(surface_gap(parts, mesh)));
  RecordProperty("parts", static_cast<int>(parts.size()));
}

TEST_F(Decompose, SeveralSolids_AreSplitOneByOne) {
  // A block pushed into the upper side of a prism, both closed, in one file.
  test::ObjMesh mesh = test::make_l_prism();
  mesh.append(test::make_block({0.2, 0.2, 0.5}, {0.6, 0.6, 1.5}));
  const auto before = coacd_calls();
  const auto parts = load_mesh(write("two.obj", mesh.text()), Vector3d::Ones(), kDecompose).parts;
  EXPECT_EQ(coacd_calls() - before, 1) << "the block is convex";
  EXPECT_EQ(parts.size(), 3u);
  EXPECT_LT(surface_gap(parts, mesh), 2e-4);
  EXPECT_NEAR(volume_of(parts), mesh.volume(), 0.01);
}

/// Both shells of a hollow box are convex, but it is one solid: the library sees them together, and says that at this threshold it is near
/// enough to convex. What becomes of the hollow at a smaller one takes as long as all the other tests together: decomposition_slow_test.
TEST_F(Decompose, Hollow_IsOneSolid) {
  test::ObjMesh mesh = test::make_hollow_box();
  const MeshOptions coarse{NonConvex::Decompose, {.threshold = 0.5, .max_parts = 16}};
  auto before = coacd_calls();
  EXPECT_EQ(load_mesh(write("hollow.obj", mesh.text()), Vector3d::Ones(), coarse).parts.size(), 1u);
  EXPECT_EQ(coacd_calls() - before, 1);

  test::ObjMesh filled = test::make_block({-1, -1, -1}, {1, 1, 1});  // the same block inside, wound outwards: a second solid
  filled.append(test::make_block({-0.6, -0.6, -0.6}, {0.6, 0.6, 0.6}));
  before = coacd_calls();
  EXPECT_EQ(load_mesh(write("filled.obj", filled.text()), Vector3d::Ones(), coarse).parts.size(), 2u);
  EXPECT_EQ(coacd_calls() - before, 0);
}

TEST_F(Decompose, FewerParts_WhenToldSo) {
  const auto file = write("ring.obj", test::make_ring(8, 4).text());
  EXPECT_LE(load_mesh(file, Vector3d::Ones(), {NonConvex::Decompose, {.threshold = 0.05, .max_parts = 3}}).parts.size(), 3u);
}

TEST_F(Decompose, WithoutACache_EqualInputGivesEqualParts) {
  const test::ObjMesh mesh = test::make_l_prism();
  Eigen::Matrix3Xd vertices(3, 12);
  Eigen::Matrix3Xi triangles(3, 20);
  for (int i = 0; i < 12; ++i) vertices.col(i) = mesh.vertices[static_cast<std::size_t>(i)];
  for (int i = 0; i < 20; ++i) triangles.col(i) = mesh.triangles[static_cast<std::size_t>(i)];
  const auto before = coacd_calls();
  const auto first = decompose(vertices, triangles, {}, {});
  EXPECT_TRUE(same(first, decompose(vertices, triangles, {}, {})));
  EXPECT_EQ(coacd_calls() - before, 2);
  // A folder that cannot be made, because a file has its name, is no error.
  EXPECT_TRUE(same(first, decompose(vertices, triangles, {}, write("file", "") / "cache")));
  EXPECT_EQ(coacd_calls() - before, 3);
}

TEST_F(Decompose, SecondLoad_DoesNotCallTheLibrary) {
  const auto file = write("l.obj", test::make_l_prism().text());
  const auto before = coacd_calls();
  const auto first = load_mesh(file, Vector3d::Ones(), kDecompose).parts;
  EXPECT_EQ(coacd_calls() - before, 1);
  EXPECT_TRUE(same(first, load_mesh(file, Vector3d::Ones(), kDecompose).parts));
  EXPECT_EQ(coacd_calls() - before, 1);
  load_mesh(file, Vector3d(1, 1, 2), kDecompose).parts;
  EXPECT_EQ(coacd_calls() - before, 2) << "other vertices";
  load_mesh(file, Vector3d::Ones(), {NonConvex::Decompose, {.threshold = 0.06, .max_parts = 16}});
  EXPECT_EQ(coacd_calls() - before, 3) << "other options";
}

TEST_F(Decompose, DamagedOrForeignCache_IsWrittenAgain) {
  const auto file = write("l.obj", test::make_l_prism().text());
  const auto first = load_mesh(file, Vector3d::Ones(), kDecompose).parts;
  fs::path cached;
  for (const auto& entry : fs::directory_iterator(default_cache_dir())) cached = entry.path();
  ASSERT_EQ(cached.extension(), ".parts") << "and nothing under a temporary name";
  const std::string good = read(cached);
  std::string flipped = good, foreign = good;
  flipped[good.size() - 3] ^= 1;
  foreign.replace(foreign.find("parts 1"), 7, "parts 0");
  auto calls = coacd_calls();
  for (const std::string& bad : {std::string(), good.substr(0, 30), good.substr(0, good.size() - 8), good + "x", flipped, foreign}) {
    std::ofstream(cached, std::ios::binary) << bad;
    EXPECT_TRUE(same(first, load_mesh(file, Vector3d::Ones(), kDecompose).parts));
    EXPECT_EQ(coacd_calls(), ++calls);
    EXPECT_EQ(read(cached), good);
  }
}

TEST_F(Decompose, CacheFolder_FollowsTheEnvironment) {
  EXPECT_EQ(default_cache_dir(), dir_ / "cache/stiction");
  xdg_cache_.set("relative");
  const char* home = std::getenv("HOME");
  EXPECT_EQ(default_cache_dir(), home != nullptr ? fs::path(home) / ".cache/stiction" : fs::path());
}

/// phi of the ball against everything else, the ball at p.
double gap_of_ball(const std::string& options, const fs::path& scene, const Vector3d& p) {
  std::ofstream(scene) << "contact_distance: 10\nobjects:\n  - {name: ball, joint: free, mass: 1, shapes: [{sphere: {radius: 0.2}}]}\n"
                       << "  - {name: bracket, joint: hinge, axis: [0, 0, 1], mass: 1, shapes: [{name: l, mesh: {file: l.obj, " << options
                       << "}}]}\n";
  const auto model = Model::make(load_scene(scene));
  Eigen::VectorXd q = model->neutral();
  q.head<3>() = p;
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  calc_kinematics(*model, q, work, kinematics);
  contact::Workspace contact_work(*model);
  std::vector<contact::Contact> contacts;
  contact::query(*model, kinematics, {}, contact_work, contacts);
  double gap = 1e300;
  for (const auto& contact : contacts) gap = std::min(gap, contact.phi);
  return gap;
}

TEST_F(Decompose, BallInTheNotch_TouchesThePartsAndSitsInTheHull) {
  write("l.obj", test::make_l_prism().text());
  const Vector3d free(1.35, 1.35, 0.5), touching(1.3, 1.15, 0.5);
  EXPECT_LT(gap_of_ball("convex_hull: true", dir_ / "hull.yaml", free), -0.2);
  EXPECT_NEAR(gap_of_ball("convex_decomposition: true", dir_ / "parts.yaml", free), 0.15, 5e-4);
  EXPECT_NEAR(gap_of_ball("convex_decomposition: {max_parts: 8}", dir_ / "parts.yaml", touching), -0.05, 5e-4);
}

TEST_F(Decompose, PartsOfObjectsAndLinks_AreNamedAfterTheirMesh) {
  write("l.obj", test::make_l_prism().text());
  write("arm.urdf", R"(<robot name="arm"><link name="base"/><link name="tip">
  <collision name="hook"><geometry><mesh filename="l.obj"/></geometry></collision>
  <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="elbow" type="continuous"><parent link="base"/><child link="tip"/></joint></robot>)");
  const auto before = coacd_calls();
  const auto model = Model::make(load_scene(write("scene.yaml", R"(
contact_distance: 1
robots: [{name: arm, urdf: arm.urdf, stiffness: 1, convex_decomposition: {threshold: 0.05, max_parts: 16}}]
fixed: [{name: rock, friction: 0.3, shapes: [{mesh: {file: l.obj, convex_decomposition: true}}, {box: {size: [1, 1, 1]}}]}]
filters: [{exclude: ["arm/tip/hook/*", "rock/box_1"]}]
)")));
  std::vector<std::string> names;
  for (const auto& geometry : model->geometries()) names.push_back(geometry.name);
  EXPECT_EQ(names, (std::vector<std::string>{"arm/tip/hook/part_0", "arm/tip/hook/part_1", "arm/tip/sphere_1", "rock/mesh_0/part_0",
                                             "rock/mesh_0/part_1", "rock/box_1"}));
  EXPECT_EQ(model->geometries()[4].friction, 0.3);
  EXPECT_EQ(model->pairs().size(), 7u);
  EXPECT_EQ(coacd_calls() - before, 1) << "the same mesh three times";
}

TEST_F(Decompose, Options_AreChecked) {
  write("l.obj", test::make_l_prism().text());
  const auto message = [&](const std::string& options) {
    const auto file = write("scene.yaml", "fixed:\n  - name: rock\n    shapes:\n      - mesh: {file: l.obj, " + options + "}\n");
    return local(message_of([&] { load_scene(file); }));
  };
  const std::string place = "scene.yaml:4: fixed[0].shapes[0].mesh.convex_decomposition";
  EXPECT_EQ(message("convex_decomposition: {thresh: 1}"),
            place + ".thresh: got an unknown key, expected one of threshold, max_parts; did you mean 'threshold'?");
  EXPECT_EQ(message("convex_decomposition: {threshold: 0.001}"), place + ".threshold: got 0.001, expected a number from 0.01 to 1");
  EXPECT_EQ(message("convex_decomposition: {max_parts: 0}"), place + ".max_parts: got 0, expected an integer ≥ 1");
  EXPECT_EQ(message("convex_decomposition: [1]"), place + ": got a list of 1, expected true, false or a map with threshold and max_parts");
  EXPECT_EQ(message("convex_decomposition: true, convex_hull: true"),
            place + ": got convex_decomposition beside convex_hull, expected one of the two");
  EXPECT_EQ(message("convex_decomposition: false, convex_hull: true"), "no exception");
  EXPECT_EQ(message("convex_decomposition: false"), "no exception");  // its parts, with the default options
}

}  // namespace
}  // namespace stiction::world
