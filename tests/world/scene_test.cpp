// Scenes as read, shapes, meshes, and the pairs that follow.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/urdf.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using std::numbers::pi;

std::filesystem::path data(const std::string& name) { return test::source_dir() / "tests/world/data" / name; }

int count_pairs(const Model& model, std::string_view a, std::string_view b) {
  int n = 0;
  for (const Pair& pair : model.pairs()) {
    const auto& name_a = model.geometries()[static_cast<std::size_t>(pair.geometry_a)].name;
    const auto& name_b = model.geometries()[static_cast<std::size_t>(pair.geometry_b)].name;
    n += matches_pattern(a, name_a) && matches_pattern(b, name_b);
  }
  return n;
}

TEST(LoadScene, EveryKeyIsRead) {
  const Scene scene = load_scene(data("everything.yaml"));
  EXPECT_EQ(scene.name, "everything");
  EXPECT_EQ(scene.gravity, Vector3d(0, 0, -9.8));
  EXPECT_EQ(scene.contact_distance, 0.1);
  EXPECT_EQ(scene.max_contacts, 12);
  ASSERT_EQ(scene.robots.size(), 1u);
  const RobotSpec& robot = scene.robots[0];
  EXPECT_EQ(robot.stiffness.front(), (std::pair<std::string, double>("slide", 100)));
  EXPECT_EQ(robot.link_friction, (std::vector<std::pair<std::string, double>>{{"left_tip", 0.2}}));
  EXPECT_LT((robot.X_WBase.R - Eigen::AngleAxisd(pi / 2, Vector3d::UnitY()).toRotationMatrix()).norm(), 1e-12) << "normalised";
  EXPECT_TRUE(robot.convex_hulls);
  ASSERT_EQ(scene.objects.size(), 5u);
  const ObjectSpec& dumbbell = scene.objects[0];
  EXPECT_EQ(dumbbell.geometries[0].friction, 0.4);
  EXPECT_EQ(dumbbell.geometries[1].friction, 0.9);
  EXPECT_NEAR(dumbbell.inertia(1, 1), 2 * 0.4 * 0.01, 1e-15);
  EXPECT_NEAR(dumbbell.inertia(0, 0), 2 * (0.4 * 0.01 + 0.09), 1e-15);
  const ObjectSpec& door = scene.objects[1];
  EXPECT_EQ(door.axis, Vector3d::UnitZ());
  EXPECT_EQ(door.p_BCom, Vector3d(0, 0.25, 0));
  EXPECT_EQ(door.limits, (std::array{0.0, 1.5}));
  EXPECT_EQ(door.joint_friction, 0.4);
  EXPECT_EQ(door.joint_damping, 0.1);
  EXPECT_EQ(door.geometries[0].max_force, std::numeric_limits<double>::infinity());
  EXPECT_EQ(scene.objects[3].geometries[0].max_force, 20);
  EXPECT_NEAR(door.inertia(2, 2), 3 * (0.05 * 0.05 + 0.25) / 12, 1e-15);
  EXPECT_EQ(scene.objects[2].p_BCom, Vector3d(0.1, 0, 0));
  EXPECT_EQ(scene.objects[2].inertia.diagonal(), Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(scene.fixed[1].X_WB.p, Vector3d(2, 0, 0));
  EXPECT_EQ(scene.filters.size(), 3u);
}

TEST(MakeModel, FiltersLimitsAndWelds_DecideThePairs) {
  const auto model = Model::make(load_scene(data("everything.yaml")));
  EXPECT_EQ(count_pairs(*model, "dumbbell/left", "floor/*"), 0);
  EXPECT_EQ(count_pairs(*model, "dumbbell/right", "floor/*"), 1);
  EXPECT_EQ(count_pairs(*model, "odd/*", "floor/*"), 0);
  EXPECT_EQ(count_pairs(*model, "odd/*", "rock/*"), 6);
  EXPECT_EQ(count_pairs(*model, "floor/*", "rock/*"), 0) << "neither moves";
  EXPECT_EQ(count_pairs(*model, "odd/rail/*", "odd/trunk/*"), 0) << "a joint between them";
  EXPECT_EQ(count_pairs(*model, "odd/rail/*", "odd/plate/*"), 0) << "plate is welded to trunk";
  EXPECT_EQ(count_pairs(*model, "odd/trunk/*", "odd/plate/*"), 0);
  EXPECT_EQ(count_pairs(*model, "odd/trunk/*", "odd/right/*"), 0) << "right hangs on plate, which is welded to trunk";
  EXPECT_EQ(count_pairs(*model, "odd/right/*", "odd/right_tip/*"), 0);
  EXPECT_EQ(count_pairs(*model, "odd/rail/*", "odd/left_tip/*"), 1);
  EXPECT_EQ(count_pairs(*model, "odd/left_tip/*", "odd/right_tip/*"), 1);
  for (const Pair& pair : model->pairs()) {
    const Geometry& a = model->geometries()[static_cast<std::size_t>(pair.geometry_a)];
    const Geometry& b = model->geometries()[static_cast<std::size_t>(pair.geometry_b)];
    EXPECT_LT(pair.geometry_a, pair.geometry_b);
    const BodyKind kind_a = model->bodies()[static_cast<std::size_t>(a.body)].kind,
                   kind_b = model->bodies()[static_cast<std::size_t>(b.body)].kind;
    const auto rank = [](BodyKind kind) { return kind == BodyKind::Object ? 0 : kind == BodyKind::Robot ? 1 : 2; };
    EXPECT_LE(rank(kind_a), rank(kind_b));
    EXPECT_EQ(pair.friction, 2 * a.friction * b.friction / (a.friction + b.friction));
    const bool limited = a.name.starts_with("door/") && b.name.starts_with("puck/");
    EXPECT_EQ(pair.max_distance, limited ? 0.02 : 0.1);
    const auto& support = model->supports()[static_cast<std::size_t>(pair.support)];
    EXPECT_TRUE(std::is_sorted(support.begin(), support.end()));
    for (const int body : {a.body, b.body}) {
      for (const int dof : model->bodies()[static_cast<std::size_t>(body)].dofs)
        EXPECT_TRUE(std::binary_search(support.begin(), support.end(), dof));
    }
  }
}

TEST(MakeModel, FrictionOfTwoSmoothSurfaces_IsZero) {
  Scene scene;
  for (const char* name : {"a", "b"}) {
    scene.objects.push_back(test::make_object(name, ObjectJoint::Free));
    scene.objects.back().geometries[0].friction = 0;
  }
  EXPECT_EQ(Model::make(scene)->pairs()[0].friction, 0);
}

TEST(MakeModel, ChainsListBranchesFirst) {
  const auto model = Model::make(load_scene(data("everything.yaml")));
  const int v = model->robots()[0].v_begin;  // slide, turn, a_left, b_left, a_right
  EXPECT_EQ(model->robots()[0].chains, (std::vector<std::vector<int>>{{v + 2, v + 3}, {v + 4}, {v, v + 1}}));
}

TEST(MakeModel, NeutralIsNearestToZeroInsideTheLimits) {
  const auto model = Model::make(load_scene(data("everything.yaml")));
  const VectorXd q = model->neutral();
  EXPECT_EQ(q.tail(5), (VectorXd(5) << 0.05, 0, -0.2, 0, 0).finished());
  EXPECT_EQ(q.head<7>(), (VectorXd(7) << 0, 0, 0, 0, 0, 0, 1).finished());
  EXPECT_EQ(model->upper()[1], std::numeric_limits<double>::infinity()) << "continuous";
}

TEST(MakeModel, ReachIsNeverExceeded) {
  // The farthest bounding-sphere point that a joint moves, at random angles, stays below reach() and comes near it for the planar arm.
  for (const auto& model :
       {test::load_task("allegro_ball"), test::load_task("planar_hand"), Model::make(load_scene(data("everything.yaml")))}) {
    core::Random random(3, 1);
    KinematicsWorkspace work(*model);
    Kinematics k;
    for (int sample = 0; sample < 200; ++sample) {
      VectorXd q = model->neutral();
      for (int i = 0; i < model->n_a(); ++i) {
        const double low = std::max(model->lower()[i], -pi), high = std::min(model->upper()[i], pi);
        q[model->n_qu() + i] = random.uniform(low, high);
      }
      calc_kinematics(*model, q, work, k);
      for (int i = 0; i < model->n_a(); ++i) {
        const int v = model->n_vu() + i;
        if (model->dofs()[static_cast<std::size_t>(v)].kind == DofKind::Prismatic) {
          EXPECT_EQ(model->reach()[i], 1);
          continue;
        }
        for (const Geometry& g : model->geometries()) {
          const auto& dofs = model->bodies()[static_cast<std::size_t>(g.body)].dofs;
          if (std::find(dofs.begin(), dofs.end(), v) == dofs.end()) continue;
          const Vector3d p = k.X_WB[static_cast<std::size_t>(g.body)] * g.p_BCenter - k.origin_W.col(v);
          EXPECT_LE(k.axis_W.col(v).cross(p).norm() + g.bounding_radius, model->reach()[i] + 1e-9) << g.name;
        }
      }
    }
  }
  const auto hand = test::load_task("planar_hand");
  EXPECT_NEAR(hand->reach()[0], 0.3 + 0.2 + 0.05, 1e-12);
  EXPECT_NEAR(hand->reach()[1], 0.2 + 0.05, 1e-12);
}

TEST(MakeModel, PlanarAxis_NeedsEverythingInOnePlane) {
  Scene scene;
  scene.objects.push_back(test::make_object("a", ObjectJoint::PlanarYZ));
  scene.objects.push_back(test::make_object("b", ObjectJoint::PlanarXY, {rotation_from_rpy({0, pi / 2, 0}), Vector3d(0, 1, 0)}));
  EXPECT_EQ(Model::make(scene)->planar_axis(), 0) << "the plane of b is turned into y-z";
  scene.objects[1].X_WP.R.setIdentity();
  EXPECT_FALSE(Model::make(scene)->planar_axis().has_value());
  EXPECT_FALSE(Model::make(Scene{})->planar_axis().has_value());
}

TEST(MakeModel, EmptyScene_HasNothing) {
  const auto model = Model::make(Scene{});
  EXPECT_EQ(model->n_q(), 0);
  EXPECT_TRUE(model->pairs().empty());
}

TEST(MakeModel, SameScene_GivesTheSameModel) {
  const auto a = Model::make(load_scene(data("everything.yaml"))), b = Model::make(load_scene(data("everything.yaml")));
  ASSERT_EQ(a->pairs().size(), b->pairs().size());
  for (std::size_t i = 0; i < a->pairs().size(); ++i) {
    EXPECT_EQ(a->pairs()[i].geometry_a, b->pairs()[i].geometry_a);
    EXPECT_EQ(a->pairs()[i].geometry_b, b->pairs()[i].geometry_b);
    EXPECT_EQ(a->pairs()[i].support, b->pairs()[i].support);
  }
}

TEST(MakeModel, JointNameOfTwoRobots_MustBeFull) {
  const auto model = test::load_task("planar_hand");
  EXPECT_EQ(model->joint_index("right/joint_2"), 3);
  try {
    static_cast<void>(model->joint_index("joint_1"));
    FAIL();
  } catch (const core::InvalidInput& e) {
    EXPECT_STREQ(e.what(), "joint: got 'joint_1', which several robots have, expected 'left/joint_1' or 'right/joint_1'");
  }
}

class EveryTask : public testing::TestWithParam<const char*> {};

TEST_P(EveryTask, LoadsWithItsVariant) {
  const auto model = test::load_task(GetParam());
  const auto variant = test::load_task(std::string(GetParam()) + "_table_3_2");
  EXPECT_EQ(variant->scene().name, std::string(GetParam()) + "_table_3_2");
  EXPECT_EQ(variant->scene().gravity, Vector3d::Zero());
  EXPECT_EQ(variant->geometries().size(), model->geometries().size());
  EXPECT_EQ(model->scene().gravity[2], std::string(GetParam()) == "allegro_ball" ? -10 : 0);
}

INSTANTIATE_TEST_SUITE_P(Tasks, EveryTask, testing::Values("planar_pushing", "planar_hand", "allegro_ball"),
                         [](const auto& task) { return std::string(task.param); });

TEST(Shapes, VolumeAndInertia_MatchSamplingOfTheBoundingBox) {
  // Monte Carlo with 4e5 points: relative error about 1/sqrt(1e5) = 0.3 %, tested at 5 sigma.
  const std::tuple<Shape, Vector3d, bool (*)(const Vector3d&)> cases[] = {
      {Sphere{0.5}, Vector3d::Constant(0.5), [](const Vector3d& p) { return p.norm() < 0.5; }},
      {Cylinder{0.3, 0.5}, {0.3, 0.3, 0.5}, [](const Vector3d& p) { return p.head<2>().norm() < 0.3; }},
      {Capsule{0.3, 0.4},
       {0.3, 0.3, 0.7},
       [](const Vector3d& p) { return (p - Vector3d(0, 0, std::clamp(p[2], -0.4, 0.4))).norm() < 0.3; }},
      {Box{{0.2, 0.3, 0.4}}, {0.2, 0.3, 0.4}, [](const Vector3d&) { return true; }},
  };
  for (const auto& [shape, half, inside] : cases) {
    core::Random random(5, 5);
    double volume = 0;
    Matrix3d second = Matrix3d::Zero();
    constexpr int kSamples = 400000;
    for (int i = 0; i < kSamples; ++i) {
      const Vector3d p = half.cwiseProduct(Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
      if (!inside(p)) continue;
      volume += 8 * half.prod() / kSamples;
      second += 8 * half.prod() / kSamples * p * p.transpose();
    }
    const VolumeProperties got = calc_volume_properties(shape);
    const Matrix3d inertia = second.trace() * Matrix3d::Identity() - second;
    EXPECT_NEAR(got.volume, volume, 0.01 * volume) << shape_name(shape);
    EXPECT_LT((got.inertia - inertia).norm(), 0.015 * inertia.norm()) << shape_name(shape);
  }
}

TEST(Shapes, MeshOfACube_HasTheInertiaOfTheBox) {
  const ConvexMesh mesh = load_mesh(data("cube.obj"), Vector3d(0.5, 1, 1.5), {}).parts.at(0);
  EXPECT_EQ(mesh.vertices.cols(), 8) << "the point inside is dropped";
  EXPECT_EQ(mesh.triangles.cols(), 12);
  const Shape shape = Mesh{std::make_shared<const ConvexMesh>(mesh)};
  const VolumeProperties got = calc_volume_properties(shape), box = calc_volume_properties(Box{{0.5, 1, 1.5}});
  EXPECT_NEAR(got.volume, 6, 1e-12);
  EXPECT_LT((got.center - Vector3d(0.5, 1, 1.5)).norm(), 1e-12);
  EXPECT_LT((got.inertia - box.inertia).norm(), 1e-12 * box.inertia.norm());
  for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t) {  // outward
    const Vector3d a = mesh.vertices.col(mesh.triangles(0, t)), b = mesh.vertices.col(mesh.triangles(1, t)),
                   c = mesh.vertices.col(mesh.triangles(2, t));
    EXPECT_GT((b - a).cross(c - a).dot(a - got.center), 0);
  }
  const BoundingSphere sphere = calc_bounding_sphere(shape);
  EXPECT_NEAR(sphere.radius, Vector3d(0.5, 1, 1.5).norm(), 1e-12);
}

TEST(Shapes, MeshThatIsNotConvex_IsReplacedByItsHull) {
  const ConvexMesh hull = load_mesh(data("notch.obj"), Vector3d::Ones(), {NonConvex::TakeHull, {}}).parts.at(0);
  EXPECT_EQ(hull.vertices.cols(), 5);
  EXPECT_NEAR(calc_volume_properties(Mesh{std::make_shared<const ConvexMesh>(hull)}).volume, 4.0 * 2 / 3, 1e-6);
}

TEST(Shapes, HullOfRandomPoints_HasAllOfThemInside) {
  core::Random random(9, 9);
  Eigen::Matrix3Xd points(3, 300);
  for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) = test::random_vector(random, 3, 1);
  const ConvexMesh hull = make_convex_hull(points);
  EXPECT_EQ(hull.triangles.cols(), 2 * hull.vertices.cols() - 4) << "Euler's formula for a closed triangle surface";
  for (Eigen::Index t = 0; t < hull.triangles.cols(); ++t) {
    const Vector3d a = hull.vertices.col(hull.triangles(0, t)), b = hull.vertices.col(hull.triangles(1, t)),
                   c = hull.vertices.col(hull.triangles(2, t));
    const Vector3d n = (b - a).cross(c - a).normalized();
    EXPECT_LT((n.transpose() * (points.colwise() - a)).maxCoeff(), 1e-12);
  }
}

TEST(Patterns, MatchRunsOfCharacters) {
  EXPECT_TRUE(matches_pattern("hand/link_*", "hand/link_12/ball_1"));
  EXPECT_TRUE(matches_pattern("*", ""));
  EXPECT_TRUE(matches_pattern("a*b*c", "aXbYbc"));
  EXPECT_FALSE(matches_pattern("a*b", "abc"));
  EXPECT_FALSE(matches_pattern("", "a"));
}

TEST(Resources, PackagesAreFoundInTheirDirsAndAbove) {
  const auto root = test::source_dir();
  const std::vector<std::filesystem::path> dirs{root};
  EXPECT_TRUE(
      std::filesystem::equivalent(find_resource("package://models/allegro_hand.urdf", "/tmp", dirs), root / "models/allegro_hand.urdf"));
  EXPECT_TRUE(std::filesystem::equivalent(find_resource("package://models/allegro_hand.urdf", root / "tests/world", {}),
                                          root / "models/allegro_hand.urdf"));
  EXPECT_TRUE(std::filesystem::equivalent(find_resource("cube.obj", data(""), {}), data("cube.obj")));
  EXPECT_EQ(find_resource("package://nowhere/x", root, dirs), "");
  EXPECT_EQ(find_resource("package://", root, dirs), "");
}

TEST(Yaml, MergeReplacesListsAndMergesMaps) {
  const YamlNode merged = merge(YamlNode::parse("a: {b: 1, c: [1, 2]}\nd: 3\n", "base"), YamlNode::parse("a: {c: [5], e: 6}\n", "over"));
  EXPECT_EQ(merged.at("a").at("b").integer(), 1);
  EXPECT_EQ(merged.at("a").at("c").vector(1)[0], 5);
  EXPECT_EQ(merged.at("a").at("e").integer(), 6);
  EXPECT_EQ(merged.at("d").number(), 3);
  EXPECT_EQ(merged.at("a").at("b").file(), "base");
  EXPECT_EQ(merged.at("a").at("e").file(), "over");
}

TEST(Yaml, NumbersAreReadInEverySpelling) {
  const YamlNode node = YamlNode::parse("[1, -2.5, 1e-3, .5, +4, 1.0E+2]", "file");
  EXPECT_EQ(node.vector(), (VectorXd(6) << 1, -2.5, 1e-3, 0.5, 4, 100).finished());
  EXPECT_EQ(YamlNode::parse("yes", "file").describe(), "'yes'");
}

}  // namespace
}  // namespace stiction::world
