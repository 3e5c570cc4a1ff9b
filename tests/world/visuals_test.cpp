#include "stiction/world/visuals.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "stiction/world/read.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Eigen::Vector4d;

/// Files of one test.
class VisualsTest : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  std::shared_ptr<const Model> model_of(const std::string& scene) const { return Model::make(parse_scene(scene, folder_)); }

  stiction::test::TemporaryFolder temporary_{};
  fs::path folder_ = temporary_.path();
};

std::vector<Visual> of_body(const Model& model, const Visuals& visuals, const std::string& name) {
  std::vector<Visual> out;
  for (const Visual& visual : visuals.visuals) {
    if (model.bodies()[static_cast<std::size_t>(visual.body)].name == name) out.push_back(visual);
  }
  return out;
}

/// A wedge with two materials, of which the file beside it says the colours.
constexpr const char* kWedge = R"(mtllib wedge.mtl
v 0 0 0
v 2 0 0
v 0 3 0
v 0 0 4
usemtl red
f 1 3 2
f 1 2 4
usemtl blue
f 1 4 3
f 2 3 4
)";
constexpr const char* kMaterials = "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n";

constexpr const char* kUrdf = R"(
robots:
  - name: arm
    urdf: |
      <robot name="arm"><material name="green"><color rgba="0 0.5 0 0.25"/></material>
      <link name="base"><visual><geometry><box size="0.2 0.4 0.6"/></geometry><material name="green"/></visual></link>
      <link name="hand"><visual><origin xyz="0.1 0 0" rpy="0 0 1.5707963267948966"/><geometry><mesh filename="wedge.obj" scale="0.1 0.1 -0.1"/></geometry></visual>
        <visual><geometry><mesh filename="wedge.obj" scale="0.1 0.1 -0.1"/></geometry><material name="own"><color rgba="0.1 0.2 0.3 1"/></material></visual>
        <visual><geometry><mesh filename="lost.stl"/></geometry></visual><visual><geometry><sphere radius="-1"/></geometry></visual>
        <collision><geometry><sphere radius="0.02"/></geometry></collision></link>
      <joint name="j" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9"/></joint></robot>
)";

TEST_F(VisualsTest, Urdf_HasShapesMeshesAndColours) {
  write("wedge.obj", kWedge);
  write("wedge.mtl", kMaterials);
  const auto model = model_of(kUrdf);
  const Visuals visuals = read_visuals(*model);

  const auto base = of_body(*model, visuals, "arm/base");
  ASSERT_EQ(base.size(), 1u);
  EXPECT_EQ(std::get<Box>(std::get<Shape>(base[0].form)).half_extents, Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(base[0].color, Vector4d(0, 0.5, 0, 0.25)) << "of the material of the robot by its name";

  const auto hand = of_body(*model, visuals, "arm/hand");
  ASSERT_EQ(hand.size(), 4u) << "two materials of the mesh, twice";
  EXPECT_EQ(visuals.meshes.size(), 2u) << "which share their triangles";
  EXPECT_EQ(hand[0].color, Vector4d(1, 0, 0, 1));
  EXPECT_EQ(hand[1].color, Vector4d(0, 0, 1, 1));
  EXPECT_EQ(hand[3].color, Vector4d(0.1, 0.2, 0.3, 1)) << "that of the URDF goes before that of the mesh";
  EXPECT_LT((hand[0].X_BV * Vector3d(1, 0, 0) - Vector3d(0.1, 1, 0)).norm(), 1e-12);

  const VisualMesh& red = *visuals.meshes[static_cast<std::size_t>(std::get<int>(hand[0].form))];
  ASSERT_EQ(red.triangles.cols(), 2);
  EXPECT_LT((red.vertices.rowwise().minCoeff() - Eigen::Vector3f(0, 0, -0.4F)).norm(), 1e-6) << "scaled";
  const auto corner = [&](int i) -> Vector3d { return red.vertices.col(red.triangles(i, 0)).cast<double>(); };
  EXPECT_GT((corner(1) - corner(0)).cross(corner(2) - corner(0))[2], 0) << "the lower face is the upper one of the mirror image";
}

TEST_F(VisualsTest, PicturesThatCannotBeRead_AreNotedAndNoFault) {
  write("wedge.obj", "nonsense");
  const auto model = model_of(kUrdf);
  const Visuals visuals = read_visuals(*model);
  EXPECT_EQ(visuals.visuals.size(), 1u) << "the box";
  ASSERT_EQ(visuals.notes.size(), 3u);
  const auto is_noted = [&](const std::string& text) {
    return std::any_of(visuals.notes.begin(), visuals.notes.end(),
                       [&](const std::string& note) { return note.starts_with("arm: not shown: ") && note.find(text) != note.npos; });
  };
  EXPECT_TRUE(is_noted("wedge.obj: mesh: got"));
  EXPECT_TRUE(is_noted("mesh filename: got 'lost.stl', which is nowhere"));
  EXPECT_TRUE(is_noted("radius"));
  for (const std::string& note : model->notes()) EXPECT_EQ(note.find("lost.stl"), note.npos) << "who plans needs no pictures";
}

/// A hand whose picture covers its collision sphere, an arm whose sphere is all that there is, a ball with a decal, a drawer, and a table that is the world's.
constexpr const char* kMjcf = R"(<mujoco><asset><mesh name="wedge" vertex="0 0 0 .2 0 0 0 .3 0 0 0 .4"/>
  <texture name="half" type="2d" builtin="checker" rgb1="1 1 1" rgb2="0 0 0" width="8" height="8"/><material name="painted" rgba="0.5 1 1 1"/>
  <material name="checkered" texture="half"/></asset><worldbody>
  <geom name="floor" type="plane" size="1 1 1"/><geom name="table" type="box" size=".5 .5 .1" pos="0 0 -.1" rgba="1 1 0 1"/>
  <geom name="collision of the table" type="box" size=".5 .5 .1" pos="2 0 -.1" group="3"/>
  <body name="arm" pos="0 0 .5"><joint name="a" axis="0 0 1"/><geom name="arm" size=".1" rgba="0 1 0 1"/>
    <body name="hand" pos=".4 0 0"><joint name="b" axis="0 0 1"/><geom name="touching" size=".05" pos=".05 .1 .1"/>
      <geom name="picture" type="mesh" mesh="wedge" contype="0" conaffinity="0" material="painted"/>
      <geom name="ghost" size=".3" contype="0" conaffinity="0" rgba="1 0 0 0"/></body></body>
  <body name="ball" pos="1 0 .2"><freejoint/><geom name="ball" size=".1" material="checkered"/>
    <geom name="inside" size=".09" contype="0" conaffinity="0"/>
    <geom name="decal" type="box" size=".02 .02 .001" pos="0 0 .1" contype="0" conaffinity="0" group="1"/></body>
  <body name="case" pos="0 1 .2" euler="0 0 90"><body name="drawer" pos=".1 0 0"><joint name="rail" type="slide" axis="1 0 0" ref=".3" range="0 1"/>
    <geom name="drawer" type="box" size=".1 .1 .1" mass="1"/></body></body>
  <body name="mark" mocap="true"><geom size=".2" contype="0" conaffinity="0"/></body>
  </worldbody><actuator><position joint="a" kp="9"/><position joint="b" kp="9"/></actuator></mujoco>)";

TEST_F(VisualsTest, Mjcf_ShowsWhatMujocoShows) {
  write("scene.xml", kMjcf);
  const auto model = model_of("{file: scene.xml}");
  const Visuals visuals = read_visuals(*model);
  EXPECT_TRUE(visuals.notes.empty());

  const auto hand = of_body(*model, visuals, "robot/hand");
  ASSERT_EQ(hand.size(), 1u) << "neither what the picture covers nor what is transparent";
  EXPECT_EQ(hand[0].color, Vector4d(0.5, 1, 1, 1));
  const VisualMesh& wedge = *visuals.meshes[static_cast<std::size_t>(std::get<int>(hand[0].form))];
  EXPECT_EQ(wedge.triangles.cols(), 4);
  Eigen::AlignedBox3d bounds;
  for (int i = 0; i < wedge.vertices.cols(); ++i) bounds.extend(hand[0].X_BV * wedge.vertices.col(i).cast<double>());
  EXPECT_LT(bounds.min().norm(), 1e-6) << "MuJoCo turns meshes; their geoms turn them back";
  EXPECT_LT((bounds.max() - Vector3d(0.2, 0.3, 0.4)).norm(), 1e-6);

  const auto arm = of_body(*model, visuals, "robot/arm");
  ASSERT_EQ(arm.size(), 1u);
  EXPECT_EQ(arm[0].color, Vector4d(0, 1, 0, 1));
  const auto ball = of_body(*model, visuals, "ball");
  ASSERT_EQ(ball.size(), 3u) << "what has a material is there to be seen, and a decal covers nothing";
  EXPECT_LT((ball[0].color - Vector4d(0.5, 0.5, 0.5, 1)).norm(), 1e-6) << "half of a checkered texture is black";

  const auto world = of_body(*model, visuals, "robot_world");
  ASSERT_EQ(world.size(), 1u) << "planes have no bounds, group 3 is hidden, and marks are no things";
  EXPECT_EQ(world[0].X_BV.p, Vector3d(0, 0, -0.1));
}

/// A geom of an object whose frame is not that of its body is where MuJoCo has it at the pose of the file.
TEST_F(VisualsTest, MjcfObjectWithAReference_IsWhereTheFileHasIt) {
  write("scene.xml", kMjcf);
  const auto model = model_of("{file: scene.xml}");
  const Visuals visuals = read_visuals(*model);
  const auto drawer = of_body(*model, visuals, "drawer");
  ASSERT_EQ(drawer.size(), 1u);
  Eigen::VectorXd q = model->neutral();
  q[model->objects()[static_cast<std::size_t>(model->object_index("drawer"))].q_begin] = 0.3;
  const Pose X_WV = object_pose(*model, q, model->object_index("drawer")) * drawer[0].X_BV;
  EXPECT_LT((X_WV.p - Vector3d(0, 1.1, 0.2)).norm(), 1e-9);
}

TEST_F(VisualsTest, MountedGripper_IsSeenOnItsLink) {
  write(
      "arm.urdf",
      R"(<robot name="arm"><link name="base"/><link name="wrist"/><joint name="j" type="revolute"><parent link="base"/><child link="wrist"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9"/></joint></robot>)");
  write("gripper.xml", R"(<mujoco><asset><mesh name="wedge" vertex="0 0 0 .2 0 0 0 .3 0 0 0 .4"/></asset><worldbody>
    <geom type="mesh" mesh="wedge" contype="0" conaffinity="0" rgba="1 0 1 1"/>
    <body name="finger"><joint name="f" type="slide"/><geom size=".01"/></body></worldbody><actuator><position joint="f" kp="9"/></actuator></mujoco>)");
  const auto model = model_of("robots: [{name: arm, urdf: arm.urdf, mount: {name: g, file: gripper.xml, on: wrist}}]");
  const Visuals visuals = read_visuals(*model);
  const auto palm = of_body(*model, visuals, "arm/g");
  ASSERT_EQ(palm.size(), 1u);
  EXPECT_EQ(palm[0].color, Vector4d(1, 0, 1, 1));
  EXPECT_EQ(of_body(*model, visuals, "arm/g_finger").size(), 1u);
}

/// Links of an object of a URDF that is a whole scene are seen with the object.
TEST_F(VisualsTest, UrdfScene_LinksOfAnObjectAreSeenWithIt) {
  write("scene.urdf",
        R"(<robot name="s"><link name="world"/><link name="arm"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <joint name="j" type="revolute"><parent link="world"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9"/></joint>
    <transmission name="t"><joint name="j"/></transmission>
    <link name="door"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial><collision><geometry><box size="1 1 1"/></geometry></collision></link>
    <joint name="hinge" type="revolute"><parent link="world"/><child link="door"/><origin xyz="3 0 0"/><axis xyz="0 0 1"/><limit lower="0" upper="1" effort="0"/></joint>
    <link name="knob"><visual><origin xyz="0 0 0.5"/><geometry><sphere radius="0.2"/></geometry></visual></link>
    <joint name="glue" type="fixed"><parent link="door"/><child link="knob"/><origin xyz="0 1 0"/></joint></robot>)");
  const auto model = model_of("{file: scene.urdf}");
  const auto door = of_body(*model, read_visuals(*model), "door");
  ASSERT_EQ(door.size(), 1u);
  EXPECT_EQ(door[0].X_BV.p, Vector3d(0, 1, 0.5));
}

/// The materials beside a mesh are read; those elsewhere are not looked for.
TEST_F(VisualsTest, MaterialsElsewhere_AreNotRead) {
  fs::create_directories(folder_ / "elsewhere");
  write("elsewhere/wedge.mtl", kMaterials);
  std::string text = kWedge;
  text.replace(text.find("wedge.mtl"), 9, "elsewhere/wedge.mtl");
  write("wedge.obj", text);
  const auto model = model_of(kUrdf);
  for (const Visual& visual : of_body(*model, read_visuals(*model), "arm/hand")) EXPECT_NE(visual.color, Vector4d(1, 0, 0, 1));
}

}  // namespace
}  // namespace stiction::world
