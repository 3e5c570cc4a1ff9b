// What is loaded stays loaded: the file of a robot is read once, and whatever later needs of it is kept.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <tuple>

#include "stiction/world/model.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/robot_tree.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr const char* kTetrahedron = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
constexpr const char* kArm = R"(<robot name="arm"><link name="base"/>
  <link name="tip"><collision><geometry><mesh filename="tip.obj"/></geometry></collision></link>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/></joint></robot>)";
constexpr const char* kArmMjcf = R"(<mujoco model="arm"><include file="assets.xml"/>
  <worldbody><geom name="floor" type="plane" size="1 1 1"/>
    <body name="tip"><joint name="elbow" axis="0 0 1" range="-57 57"/><geom type="mesh" mesh="tip"/></body>
    <body name="ball" pos="0 0 1"><freejoint/><geom type="sphere" size="0.1"/></body></worldbody></mujoco>)";

class LoadedRobot : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const { std::ofstream(dir_ / name, std::ios::binary) << text; }

  /// A cart whose joint x has the given limits, and that may have more elements.
  std::shared_ptr<const Model> cart(const std::string& limit, const std::string& more = "") const {
    write(
        "cart.urdf",
        "<robot name='cart'><link name='rail'/><link name='body'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
        "<joint name='x' type='prismatic'><parent link='rail'/><child link='body'/><axis xyz='1 0 0'/>" +
            limit + "</joint>" + more + "</robot>");
    Scene scene;
    RobotSpec& robot = scene.robots.emplace_back();
    robot.name = "cart";
    robot.urdf = dir_ / "cart.urdf";
    robot.stiffness = {{"x", 100}};
    return Model::make(scene);
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& dir_ = temporary_.path();
};

TEST_F(LoadedRobot, SpeedLimits_AreThoseOfTheFileAndInfiniteWhereItSaysNothing) {
  EXPECT_EQ(cart("<limit lower='-1' upper='1' effort='5' velocity='0.25'/>")->speed_limit()[0], 0.25);
  EXPECT_EQ(cart("<limit lower='-1' upper='1' effort='5' velocity=' +2.5e-1 '/>")->speed_limit()[0], 0.25);
  for (const char* none : {"", "velocity='0'", "velocity='inf'", "velocity='1e999'"})
    EXPECT_EQ(cart(std::string("<limit lower='-1' upper='1' effort='5' ") + none + "/>")->speed_limit()[0], kNone) << none;
}

TEST_F(LoadedRobot, SpeedLimit_OfAFollowerHoldsBackItsLeader) {
  const auto with_follower = [&](const std::string& ratio) {
    return cart("<limit lower='-1' upper='1' effort='5' velocity='0.25'/>",
                "<link name='wheel'/><joint name='turn' type='revolute'><parent link='body'/><child link='wheel'/><axis xyz='0 1 0'/>"
                "<limit lower='-9' upper='9' effort='1' velocity='0.3'/><mimic joint='x' multiplier='" +
                    ratio + "'/></joint>")
        ->speed_limit()[0];
  };
  EXPECT_DOUBLE_EQ(with_follower("-3"), 0.1);
  EXPECT_EQ(with_follower("0.5"), 0.25);
  EXPECT_EQ(with_follower("0"), 0.25);
}

TEST_F(LoadedRobot, SpeedLimit_ThatIsNoneIsNamedWithItsLine) {
  for (const char* text : {"fast", "", "-1", "nan", "3.14rad", "1,5"}) {
    const std::string message =
        test::message_of([&] { (void)cart(std::string("<limit lower='-1' upper='1' effort='5' velocity='") + text + "'/>"); });
    EXPECT_NE(
        message.find("cart.urdf:1: joint 'x' velocity: got '" + std::string(text) + "', expected a number > 0, or 0 where it is not known"),
        std::string::npos)
        << message;
  }
}

TEST_F(LoadedRobot, WorksOnWithoutItsFiles) {
  for (const auto& [key, name, text] : {std::tuple{"urdf", "arm.urdf", kArm}, std::tuple{"mjcf", "arm.xml", kArmMjcf}}) {
    write("tip.obj", kTetrahedron);
    write("assets.xml", "<mujoco><asset><mesh name='tip' file='tip.obj'/></asset></mujoco>");
    write(name, text);
    const std::string robot = std::string("robots: [{name: arm, ") + key + ": " + name + "}]";
    const Scene scene = parse_scene(robot, dir_);
    const auto before = Model::make(scene);
    for (const auto& entry : fs::directory_iterator(dir_)) fs::remove(entry);

    const auto after = Model::make(scene);
    Scene slippery = after->scene();
    for (auto& spec : slippery.robots) spec.friction = 0.1;
    const auto third = Model::make(slippery);
    for (const auto& model : {after, third}) {
      ASSERT_EQ(model->geometries().size(), before->geometries().size()) << key;
      EXPECT_EQ(model->objects().size(), before->objects().size());
      EXPECT_EQ(model->speed_limit(), before->speed_limit());
      EXPECT_EQ(model->upper(), before->upper());
      EXPECT_EQ(model->scene().robots[0].contents->sha256, before->scene().robots[0].contents->sha256);
    }
  }
}

TEST_F(LoadedRobot, IsNotChangedByAnEditOfItsFile) {
  write("tip.obj", kTetrahedron);
  write("arm.urdf", kArm);
  const Scene scene = parse_scene("robots: [{name: arm, urdf: arm.urdf}]", dir_);
  write("arm.urdf", "<robot name='other'><link name='else'/></robot>");
  EXPECT_EQ(Model::make(scene)->dofs()[0].name, "arm/elbow");
}

TEST_F(LoadedRobot, MeshOfSeveralLinks_IsTheSameInEach) {
  write("tip.obj", kTetrahedron);
  write("arm.urdf", R"(<robot name="arm"><link name="base"><collision><geometry><mesh filename="tip.obj"/></geometry></collision>
    <collision><origin xyz="1 0 0"/><geometry><mesh filename="tip.obj"/></geometry></collision>
    <collision><geometry><mesh filename="tip.obj" scale="2 1 1"/></geometry></collision></link></robot>)");
  const Scene scene = parse_scene("robots: [{name: arm, urdf: arm.urdf}]", dir_);
  std::vector<std::shared_ptr<const ConvexMesh>> meshes;
  for (const auto& collision : scene.robots[0].contents->robot.links[0].collisions) meshes.push_back(std::get<Mesh>(collision.shape).mesh);
  ASSERT_EQ(meshes.size(), 3u);
  EXPECT_EQ(meshes[0]->vertices, meshes[1]->vertices);
  EXPECT_EQ(meshes[0]->triangles, meshes[1]->triangles);
  EXPECT_EQ(*meshes[0]->surface, *meshes[1]->surface);
  EXPECT_NE(meshes[0]->surface, meshes[1]->surface) << "shapes with one surface would count as parts of one file";
  EXPECT_EQ(meshes[2]->vertices.row(0).maxCoeff(), 2 * meshes[0]->vertices.row(0).maxCoeff());
}

TEST_F(LoadedRobot, IsReadAnewForOtherKeys) {
  write("tip.obj", kTetrahedron);
  write("arm.urdf", kArm);
  write("cart.urdf",
        "<robot name='cart'><link name='rail'/><link name='body'/><joint name='x' type='prismatic'><parent link='rail'/>"
        "<child link='body'/></joint></robot>");
  Scene scene = parse_scene("robots: [{name: arm, urdf: arm.urdf}]", dir_);
  const auto first = scene.robots[0].contents;
  scene.robots[0].friction = 0.3;
  EXPECT_EQ(contents_of(scene.robots[0]), first);
  scene.robots[0].convex_hulls = true;
  EXPECT_NE(contents_of(scene.robots[0]), first);
  scene.robots[0].urdf = dir_ / "cart.urdf";
  EXPECT_EQ(Model::make(scene)->dofs()[0].name, "arm/x");
}

}  // namespace
}  // namespace stiction::world
