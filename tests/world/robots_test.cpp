// Robots as others write them: what is taken otherwise than the file says, what is chosen where it says nothing, and what the notes say of it.
#include <array>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/overlap.hpp"
#include "world/mesh_files.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world {
namespace {

using Eigen::Vector3d;

class Robots : public test::MeshFiles {
 protected:
  /// The model of a scene with a robot r of this URDF. @param more  keys of the robot  @param rest  of the scene
  std::shared_ptr<const Model> load(const std::string& urdf, const std::string& more = "", const std::string& rest = "") {
    write("r.urdf", "<robot name='r'>" + urdf + "</robot>");
    return Model::make(load_scene(write("scene.yaml", "robots:\n  - name: r\n    urdf: r.urdf\n" + more + rest)));
  }

  static std::string link(const std::string& name, const std::string& content = "") {
    return "<link name='" + name + "'>" + content + "</link>";
  }
  static std::string collision(const std::string& geometry) { return "<collision><geometry>" + geometry + "</geometry></collision>"; }
  static std::string joint(const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                           const std::string& content) {
    return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/>" + content +
           "</joint>";
  }
  static std::vector<std::string> notes(const Model& model) { return {model.notes().begin(), model.notes().end()}; }
};

constexpr const char* kLimit = "<limit lower='-1' upper='1' effort='10' velocity='1'/>";
const std::string kStiff = "    stiffness: 5\n";

TEST_F(Robots, OrdinaryFile_HasNoNotes) {
  const auto model = load(link("a") + link("b", collision("<sphere radius='0.1'/>")) + joint("j", "revolute", "a", "b", kLimit), kStiff);
  EXPECT_EQ(notes(*model), std::vector<std::string>());
}

TEST_F(Robots, MeshThatIsNotConvex_IsItsHullAndNamed) {
  write("l.obj", test::make_l_prism().text());
  const std::string urdf = link("a") + link("b", collision("<mesh filename='l.obj'/>")) + joint("j", "revolute", "a", "b", kLimit);
  const auto model = load(urdf, kStiff);
  EXPECT_EQ(notes(*model), std::vector<std::string>{"r: collision meshes that are not convex are their convex hulls: l.obj"});
  ASSERT_EQ(model->geometries().size(), 1u);
  EXPECT_NEAR(calc_volume_properties(model->geometries()[0].shape).volume, 3.5, 1e-9);
  EXPECT_EQ(notes(*load(urdf, kStiff + "    convex_hulls: true\n")), std::vector<std::string>());
}

TEST_F(Robots, InertiaThatNoBodyHas_IsThatOfTheGeometryAndNamed) {
  const auto inertial = [](double m, double xx, double yy, double zz) {
    return "<inertial><mass value='" + std::to_string(m) + "'/><inertia ixx='" + std::to_string(xx) + "' iyy='" + std::to_string(yy) +
           "' izz='" + std::to_string(zz) + "' ixy='0' ixz='0' iyz='0'/></inertial>";
  };
  const std::string ball = collision("<sphere radius='0.1'/>");
  const auto model = load(link("a") + link("rod", ball + inertial(2, 0.1, 0.1, 0)) + link("odd", ball + inertial(2, 0.1, 0.01, 0.01)) +
                              link("negative", ball + inertial(-2, 0.1, 0.1, 0.1)) + joint("i", "revolute", "a", "rod", kLimit) +
                              joint("j", "revolute", "a", "odd", kLimit) + joint("k", "revolute", "a", "negative", kLimit),
                          kStiff, "filters: [{exclude: [r, r]}]\n");
  const auto body = [&](const std::string& name) -> const BodyInertia& {
    for (std::size_t i = 0; i < model->bodies().size(); ++i) {
      if (model->bodies()[i].name == name) return model->inertias()[i];
    }
    throw std::out_of_range(name);
  };
  EXPECT_LE((body("r/rod").inertia - Eigen::Matrix3d(Vector3d(0.1, 0.1, 0).asDiagonal())).norm(), 1e-15);  // a thin rod is a body
  EXPECT_EQ(body("r/odd").mass, 2);
  EXPECT_LE((body("r/odd").inertia - 0.4 * 2 * 0.01 * Eigen::Matrix3d::Identity()).norm(), 1e-12);  // of a ball
  EXPECT_NEAR(body("r/negative").mass, 1000 * 4.0 / 3 * M_PI * 1e-3, 1e-9);
  EXPECT_EQ(notes(*model),
            std::vector<std::string>{"r: inertias that no body can have are those of the collision geometry with the mass of "
                                     "the file, of links: odd, negative"});
}

TEST_F(Robots, StiffnessThatNobodyStates_BearsTheEffortAtAFortiethOfTheRange) {
  const std::string urdf = link("a") + link("b", collision("<sphere radius='0.1'/>")) + link("c", collision("<sphere radius='0.1'/>")) +
                           joint("j", "revolute", "a", "b", kLimit) +
                           joint("k", "continuous", "b", "c", "<origin xyz='0 0 1'/><axis xyz='0 1 0'/><limit effort='3' velocity='1'/>");
  const auto model = load(urdf);
  EXPECT_NEAR(model->stiffness()[0], 10 / (2.0 / 40), 1e-12);
  EXPECT_NEAR(model->stiffness()[1], 3 / (2 * M_PI / 40), 1e-12);
  EXPECT_EQ(notes(*model),
            std::vector<std::string>{"r: stiffness of joints without one, which bear their effort at 1/40 of their range [N·m/rad, "
                                     "N/m]: j 200, k 19.1"});
  const auto some = load(urdf, "    stiffness: {j: 7}\n");
  EXPECT_EQ(some->stiffness()[0], 7);
  EXPECT_NEAR(some->stiffness()[1], 3 / (2 * M_PI / 40), 1e-12);
}

TEST_F(Robots, LimitsThatAreMissing_AreNamed) {
  const auto model = load(link("a") + link("b") + link("c") + link("d") + joint("free", "revolute", "a", "b", "") +
                              joint("fast", "revolute", "b", "c", "<limit effort='1' velocity='1'/>") +
                              joint("still", "prismatic", "c", "d", "<axis xyz='0 0 1'/><limit lower='0.2' upper='0.2'/>"),
                          kStiff);
  ASSERT_EQ(model->n_a(), 2);
  for (int j = 0; j < 2; ++j) EXPECT_TRUE(std::isinf(model->upper()[j]) && std::isinf(model->lower()[j])) << j;
  EXPECT_EQ(model->effort()[1], 1);
  KinematicsWorkspace work(*model);
  Kinematics k;
  calc_kinematics(*model, model->neutral(), work, k);
  EXPECT_LE((k.X_WB.back().p - Vector3d(0, 0, 0.2)).norm(), 1e-15);
  EXPECT_EQ(notes(*model), (std::vector<std::string>{
                               "r: no limits in the file, so that these joints have none: free, fast",
                               "r: lower and upper limit are the same, so that these joints stand still: still",
                               "r: motors whose effort nobody states (or states as 0), and which may bear anything, of joints: free"}));
}

/// Two fingers, the left one of two links whose outer follows the inner one, the right one follows the left.
std::string follower_urdf() {
  const auto link = [](const std::string& name) {
    return "<link name='" + name + "'><collision><origin xyz='0.3 0 0'/><geometry><sphere radius='0.01'/></geometry></collision></link>";
  };
  const auto joint = [](const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                        const std::string& more) {
    return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child +
           "'/><origin xyz='0 0.1 0.2' rpy='0.3 0 0.1'/><axis xyz='0 0 1'/>" + more + "</joint>";
  };
  return "<link name='palm'/>" + link("outer") + link("inner") + link("right") +
         joint("right", "prismatic", "palm", "right",
               "<limit lower='-1' upper='0.1' effort='1' velocity='1'/><mimic joint='outer' multiplier='0.5'/>") +
         joint("inner", "revolute", "palm", "inner", "<limit lower='-2' upper='2' effort='1' velocity='1'/>") +
         joint("outer", "revolute", "inner", "outer",
               "<limit lower='-3' upper='3' effort='1' velocity='1'/><mimic joint='inner' multiplier='2' offset='-1'/>");
}

/// As files for Bullet write joints without limits.
TEST_F(Robots, LimitsThatAreReversed_AreNoneAndNamed) {
  const auto model = load(link("a") + link("b") + joint("j", "revolute", "a", "b", "<limit lower='1' upper='-1' effort='2'/>"), kStiff);
  EXPECT_TRUE(std::isinf(model->upper()[0]) && std::isinf(model->lower()[0]));
  EXPECT_EQ(notes(*model), std::vector<std::string>{"r: a lower limit above the upper one, so that these joints have none: j"});
}

TEST_F(Robots, NumbersWithCommas_AreRead) {
  const auto model =
      load(link("a") + link("b") + joint("j", "revolute", "a", "b", "<origin xyz='0.1, 0,-0.2'/><limit effort='1'/>"), kStiff);
  KinematicsWorkspace work(*model);
  Kinematics k;
  calc_kinematics(*model, model->neutral(), work, k);
  EXPECT_EQ(k.X_WB.back().p, Vector3d(0.1, 0, -0.2));
}

TEST_F(Robots, JointsThatFollow_MoveWithTheirLeader) {
  const auto model = load(follower_urdf(), kStiff);
  ASSERT_EQ(model->n_a(), 1);
  ASSERT_EQ(model->followers().size(), 2u);
  // right = ½ outer = inner − ½, in [−1, 0.1]; outer = 2 inner − 1 in [−3, 3]
  EXPECT_DOUBLE_EQ(model->lower()[0], -0.5);
  EXPECT_DOUBLE_EQ(model->upper()[0], 0.6);
  KinematicsWorkspace work(*model);
  const auto poses = [&](double q) {
    Kinematics k;
    calc_kinematics(*model, Eigen::VectorXd::Constant(1, q), work, k);
    return k;
  };
  const double q = 0.3, step = 1e-6;
  const Kinematics k = poses(q), above = poses(q + step), below = poses(q - step);
  const auto local = [](double roll) { return Pose{rotation_from_rpy({roll, 0, 0.1}), {0, 0.1, 0.2}}; };
  const auto turn = [](double angle) { return Pose{rotation_from_rpy({0, 0, angle}), Vector3d::Zero()}; };
  const Pose X_inner = local(0.3) * turn(q), X_outer = X_inner * local(0.3) * turn(2 * q - 1);
  const Pose X_right = local(0.3) * Pose{Eigen::Matrix3d::Identity(), {0, 0, q - 0.5}};
  for (std::size_t b = 0; b < model->bodies().size(); ++b) {
    const Body& body = model->bodies()[b];
    if (body.name == "r/palm") continue;
    const Pose& want = body.name == "r/inner" ? X_inner : body.name == "r/outer" ? X_outer : X_right;
    EXPECT_LE((k.X_WB[b].R - want.R).norm() + (k.X_WB[b].p - want.p).norm(), 1e-14) << body.name;
    EXPECT_EQ(body.dofs, std::vector<int>{0}) << body.name;
    // Velocity of a point as the sum over the axes.
    const Vector3d p_B(0.3, 0.1, -0.2), p_W = k.X_WB[b] * p_B, v = (above.X_WB[b] * p_B - below.X_WB[b] * p_B) / (2 * step);
    Vector3d sum = Vector3d::Zero();
    for (const int a : body.axes) {
      const Follower* f = a < model->n_v() ? nullptr : &model->followers()[static_cast<std::size_t>(a - model->n_v())];
      const bool revolute = f == nullptr || f->kind == DofKind::Revolute;
      const Vector3d axis = k.axis_W.col(a);
      sum += (f ? f->ratio : 1.0) * (revolute ? Vector3d(axis.cross(p_W - k.origin_W.col(a))) : axis);
    }
    EXPECT_LE((v - sum).norm(), 1e-8) << body.name;
    EXPECT_GT(v.norm(), 0.1) << body.name;
  }
}

TEST_F(Robots, LinksThatOverlapAtRest_NeverTouchAndAreNamed) {
  const std::string box = collision("<box size='0.2 0.2 0.2'/>");
  const std::string urdf = link("a", box) + link("b") + link("c", box) + link("d", box) + joint("i", "revolute", "a", "b", kLimit) +
                           joint("j", "revolute", "b", "c", std::string("<origin xyz='0.1 0 0'/>") + kLimit) +
                           joint("k", "revolute", "b", "d", std::string("<origin xyz='0 0.5 0'/>") + kLimit);
  const auto model = load(urdf, kStiff);
  EXPECT_EQ(model->pairs().size(), 2u);  // a with d, c with d
  EXPECT_EQ(notes(*model), std::vector<std::string>{"r: 1 pair of its links overlaps at rest and never touches: a and c"});
  Scene scene = load_scene(dir_ / "scene.yaml");
  scene.rest = {0, 0, 1};  // d turned into nothing else: the same
  EXPECT_EQ(Model::make(scene)->pairs().size(), 2u);
}

TEST_F(Robots, Srdf_KeepsPairsFromTouching) {
  write("r.srdf",
        "<robot name='r'><disable_collisions link1='b' link2='d' reason='Never'/>\n<disable_collisions link1='b' link2='gone'/></robot>");
  const std::string ball = collision("<sphere radius='0.1'/>");
  const std::string urdf = link("a") + link("b", ball) + link("c") + link("d", ball) + joint("i", "revolute", "a", "b", kLimit) +
                           joint("j", "revolute", "b", "c", kLimit) +
                           joint("k", "revolute", "c", "d", std::string("<origin xyz='0.22 0 0'/>") + kLimit);
  EXPECT_EQ(load(urdf, kStiff)->pairs().size(), 1u);
  EXPECT_EQ(load(urdf, kStiff + "    srdf: r.srdf\n")->pairs().size(), 0u);
  write("r.srdf", "<robot name='r'>\n<disable_collisions link1='b'/></robot>");
  try {
    load(urdf, kStiff + "    srdf: r.srdf\n");
    FAIL();
  } catch (const core::InvalidInput& e) {
    EXPECT_EQ(local(e.what()), "r.srdf:2: disable_collisions: got no attribute link2, expected one");
  }
}

TEST_F(Robots, PushWith_LeavesOnlyTheseLinksToObjects) {
  const std::string ball = collision("<sphere radius='0.1'/>");
  const std::string urdf = link("a", ball) + link("b", ball) + joint("i", "revolute", "a", "b", kLimit);
  const std::string rest =
      "objects:\n  - {name: o, joint: free, mass: 1, shapes: [{sphere: {radius: 0.1}}]}\nfixed:\n  - {name: table, shapes: [{half_space: "
      "{}}]}\n";
  EXPECT_EQ(load(urdf, kStiff, rest)->pairs().size(), 4u);  // o with a, b, table; b with table
  const auto model = load(urdf, kStiff + "    push_with: [b]\n", rest);
  EXPECT_EQ(model->pairs().size(), 3u);
  for (const Pair& pair : model->pairs()) EXPECT_NE(model->geometries()[static_cast<std::size_t>(pair.geometry_b)].name, "r/a/sphere_0");
}

TEST(Overlap, OfEveryPairOfShapes_IsWhereTheyMeet) {
  std::vector<Shape> shapes = {Sphere{0.1}, Capsule{0.05, 0.05}, Box{{0.1, 0.1, 0.1}}, Cylinder{0.1, 0.1}};
  auto octahedron = std::make_shared<ConvexMesh>(
      make_convex_hull((Eigen::Matrix3Xd(3, 6) << 0.1, -0.1, 0, 0, 0, 0, 0, 0, 0.1, -0.1, 0, 0, 0, 0, 0, 0, 0.1, -0.1).finished()));
  shapes.emplace_back(Mesh{octahedron});
  // All reach 0.1 along z from their origin, so that two of them along z meet at a distance of 0.2, wherever both are turned about z.
  for (const Shape& a : shapes) {
    for (const Shape& b : shapes) {
      const auto meets = [&](double z) {
        const Pose X_WA{rotation_from_rpy({0, 0, 0.3}), {1, 2, 3}}, X_WB{rotation_from_rpy({0, 0, 1.1}), {1, 2, 3 + z}};
        return overlap(a, X_WA, b, X_WB);
      };
      for (const double z : {0.0, 0.05, 0.1999, 0.2}) EXPECT_TRUE(meets(z)) << shape_name(a) << " " << shape_name(b) << " " << z;
      for (const double z : {0.2001, 0.3, 10.0}) EXPECT_FALSE(meets(z)) << shape_name(a) << " " << shape_name(b) << " " << z;
    }
  }
}

TEST(Overlap, OfTurnedBoxes_AgreesWithSeparatingAxes) {
  core::Random random(4, 4);
  int yes = 0, no = 0;
  for (int i = 0; i < 2000; ++i) {
    const Box a{{0.1, 0.2, 0.3}}, b{{0.25, 0.05, 0.15}};
    const Pose X_WA = test::random_pose(random);
    Pose X_WB = test::random_pose(random);
    X_WB.p = X_WA.p + 0.25 * X_WB.p;
    // The fifteen axes of two boxes.
    const auto gap = [&](const Vector3d& n) {
      return std::abs(n.dot(X_WB.p - X_WA.p)) - (X_WA.R.transpose() * n).cwiseAbs().dot(a.half_extents) -
             (X_WB.R.transpose() * n).cwiseAbs().dot(b.half_extents);
    };
    double largest = -1;
    for (int k = 0; k < 3; ++k) {
      largest = std::max({largest, gap(X_WA.R.col(k)), gap(X_WB.R.col(k))});
      for (int l = 0; l < 3; ++l) largest = std::max(largest, gap(X_WA.R.col(k).cross(X_WB.R.col(l)).normalized()));
    }
    if (std::abs(largest) < 1e-5) continue;
    EXPECT_EQ(overlap(a, X_WA, b, X_WB), largest < 0) << i << " " << largest;
    ++(largest < 0 ? yes : no);
  }
  EXPECT_GT(yes, 300);
  EXPECT_GT(no, 300);
}

}  // namespace
}  // namespace stiction::world
