// Scenes that are in one URDF: which links are the robot, objects or fixed, and what the objects weigh, beside MuJoCo's own reading of the file.
#include "stiction/world/urdf_scene.hpp"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <fstream>
#include <memory>

#include "stiction/world/model.hpp"
#include "stiction/world/read.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using stiction::test::message_of;

constexpr const char* kInertia = R"(<inertia ixx="0.002" iyy="0.003" izz="0.004" ixy="0.0005" ixz="0" iyz="0"/>)";

/// A finger on two slides, a drawer with a knob in a turned case, a lid on the drawer, a cube that floats, and a place on the floor.
std::string cell() {
  const auto inertial = [](const char* mass, const char* origin) {
    return std::string("<inertial><origin ") + origin + "/><mass value=\"" + mass + "\"/>" + kInertia + "</inertial>";
  };
  return R"(<robot name="cell"><link name="world"/>
  <link name="base"><collision><geometry><box size=".1 .1 .1"/></geometry></collision></link>
  <joint name="mount" type="fixed"><parent link="world"/><child link="base"/><origin xyz="0 0 .2"/></joint>
  <link name="slide">)" +
         inertial("1", "xyz='0 0 0'") + R"(</link>
  <joint name="x" type="prismatic"><parent link="base"/><child link="slide"/><axis xyz="1 0 0"/><limit lower="-.6" upper=".6" effort="60" velocity="1"/></joint>
  <link name="finger">)" +
         inertial("0.2", "xyz='0 0 0'") + R"(<collision name="tip"><geometry><sphere radius=".03"/></geometry></collision></link>
  <joint name="y" type="prismatic"><parent link="slide"/><child link="finger"/><origin xyz="0 .3 0"/><axis xyz="0 1 0"/><limit lower="-.6" upper=".6" effort="60" velocity="1"/></joint>
  <link name="case"><collision name="wall"><origin xyz="0 .12 0"/><geometry><box size=".3 .01 .2"/></geometry></collision></link>
  <joint name="stand" type="fixed"><parent link="world"/><child link="case"/><origin xyz=".5 .5 .2" rpy="0 0 1.2"/></joint>
  <link name="drawer">)" +
         inertial("0.5", "xyz='.01 0 0' rpy='.3 0 0'") +
         R"(<collision name="box"><geometry><box size=".1 .2 .1"/></geometry></collision></link>
  <joint name="rail" type="prismatic"><parent link="case"/><child link="drawer"/><origin xyz="0 0 .05" rpy=".4 0 0"/><axis xyz="1 0 0"/><limit lower="0" upper=".25" effort="0" velocity="0"/><dynamics damping="2" friction=".3"/></joint>
  <link name="knob">)" +
         inertial("0.1", "xyz='0 0 .02'") + R"(<collision name="ball"><geometry><sphere radius=".02"/></geometry></collision></link>
  <joint name="glue" type="fixed"><parent link="drawer"/><child link="knob"/><origin xyz="0 -.15 0" rpy="0 .7 0"/></joint>
  <link name="lid">)" +
         inertial("0.3", "xyz='0 .05 0'") + R"(<collision name="plate"><geometry><box size=".1 .1 .01"/></geometry></collision></link>
  <joint name="hinge" type="continuous"><parent link="knob"/><child link="lid"/><origin xyz="0 0 .1"/><axis xyz="0 1 0"/></joint>
  <link name="cube">)" +
         inertial("0.3", "xyz='0 0 0'") + R"(<collision name="box"><geometry><box size=".05 .05 .05"/></geometry></collision></link>
  <joint name="loose" type="floating"><parent link="world"/><child link="cube"/><origin xyz="-.4 0 .025" rpy="0 0 .3"/></joint>
  <link name="spot"/><joint name="mark" type="fixed"><parent link="world"/><child link="spot"/><origin xyz="-.4 .2 .025"/></joint>
  <transmission name="t"><joint name="x"/></transmission>
  <ros2_control name="c" type="system"><joint name="y"><command_interface name="position"/></joint><joint name="rail"><state_interface name="position"/></joint></ros2_control>
</robot>)";
}

class UrdfScene : public testing::Test {
 protected:
  UrdfScene() { std::ofstream(dir_ / "cell.urdf") << cell(); }
  Scene read(const std::string& extra = "") const { return parse_scene("file: cell.urdf\n" + extra, dir_); }
  std::string refused(const std::string& extra) const {
    return message_of([&] { (void)read(extra); });
  }
  const ObjectSpec& object(const Scene& scene, const std::string& name) const {
    return *std::find_if(scene.objects.begin(), scene.objects.end(), [&](const ObjectSpec& o) { return o.name == name; });
  }

  fs::path dir_ = stiction::test::folder_of_the_process();
};

TEST_F(UrdfScene, TreesWithMotorsAreTheRobot_OthersAreObjects) {
  const auto model = Model::make(read());
  std::vector<std::string> joints;
  for (int j = 0; j < model->n_a(); ++j) joints.push_back(model->dofs()[static_cast<std::size_t>(model->n_vu() + j)].name);
  EXPECT_EQ(joints, (std::vector<std::string>{"robot/x", "robot/y"}));
  ASSERT_EQ(model->objects().size(), 3u);
  const Scene scene = read();
  const ObjectSpec &drawer = object(scene, "drawer"), &lid = object(scene, "lid"), &cube = object(scene, "cube");
  EXPECT_EQ(drawer.joint, ObjectJoint::Slider);
  EXPECT_EQ((*drawer.limits)[1], 0.25);
  EXPECT_EQ(drawer.joint_damping, 2);
  EXPECT_EQ(drawer.joint_friction, 0.3);
  EXPECT_EQ(drawer.geometries.size(), 2u) << "with the knob";
  EXPECT_EQ(drawer.geometries[1].name, "knob.ball");
  EXPECT_EQ(lid.joint, ObjectJoint::Hinge);
  EXPECT_EQ(lid.parent, "drawer");
  EXPECT_FALSE(lid.limits);
  EXPECT_EQ(cube.joint, ObjectJoint::Free);
  for (const auto& pair : model->pairs()) {
    const std::string a = model->geometries()[static_cast<std::size_t>(pair.geometry_a)].name,
                      b = model->geometries()[static_cast<std::size_t>(pair.geometry_b)].name;
    EXPECT_FALSE((a == "drawer/box" && b == "robot/case/wall") || (b == "drawer/box" && a == "robot/case/wall")) << "a joint links them";
  }
  const auto& places = scene.robots[0].contents->places;
  const auto spot = std::find_if(places.begin(), places.end(), [](const FilePlace& place) { return place.name == "spot"; });
  EXPECT_TRUE(spot->moved_by.empty());
  EXPECT_TRUE(spot->X_WF.p.isApprox(Vector3d(-0.4, 0.2, 0.025)));
}

/// MuJoCo reads URDF as well: bodies of one joint are where it has them, and weigh what it says.
TEST_F(UrdfScene, ObjectsAreWhereMujocoHasThem) {
  char error[500] = "";
  const std::unique_ptr<mjModel, void (*)(mjModel*)> m(mj_loadXML((dir_ / "cell.urdf").c_str(), nullptr, error, sizeof(error)),
                                                       mj_deleteModel);
  ASSERT_NE(m, nullptr) << error;
  const std::unique_ptr<mjData, void (*)(mjData*)> d(mj_makeData(m.get()), mj_deleteData);
  const auto model = Model::make(read());
  Eigen::VectorXd q = model->neutral();
  for (const auto& [name, value] : {std::pair{"rail", 0.1}, {"hinge", 0.7}})
    d->qpos[m->jnt_qposadr[mj_name2id(m.get(), mjOBJ_JOINT, name)]] = value;
  mj_kinematics(m.get(), d.get());
  mj_comPos(m.get(), d.get());
  for (std::size_t i = 0; i < model->objects().size(); ++i) {
    const ObjectInfo& info = model->objects()[i];
    if (info.name == "drawer") q[info.q_begin] = 0.1;
    if (info.name == "lid") q[info.q_begin] = 0.7;
    if (info.name == "cube") q.segment<7>(info.q_begin) = model->scene().robots[0].contents->as_written.objects[2].second;
  }
  for (std::size_t i = 0; i < model->objects().size(); ++i) {
    const ObjectInfo& info = model->objects()[i];
    const int b = mj_name2id(m.get(), mjOBJ_BODY, info.name.c_str());
    ASSERT_GE(b, 0) << info.name;
    const Pose X = object_pose(*model, q, static_cast<int>(i));
    const ObjectSpec& spec = model->scene().objects[i];
    EXPECT_NEAR(spec.mass, m->body_mass[b], 1e-12);
    EXPECT_TRUE((X * spec.p_BCom).isApprox(Eigen::Map<const Vector3d>(d->xipos + 3 * b), 1e-9)) << info.name;
    const Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(d->ximat + 9 * b);
    const Matrix3d inertia = R * Eigen::Map<const Vector3d>(m->body_inertia + 3 * b).asDiagonal() * R.transpose();
    EXPECT_TRUE((X.R * spec.inertia * X.R.transpose()).isApprox(inertia, 1e-6)) << info.name;
  }
}

TEST_F(UrdfScene, NamesSayWhatMoves) {
  const Scene one = read("objects: [cube]");
  ASSERT_EQ(one.objects.size(), 1u);
  EXPECT_EQ(Model::make(one)->n_a(), 2) << "the drawer stands still, with its knob and lid";
  const Scene all = read("robot: {bodies: [drawer]}");
  EXPECT_EQ(Model::make(all)->n_a(), 4);
  EXPECT_NE(refused("objects: [case]").find("urdf: got link 'case' as object, which no joint moves, expected a link that a joint moves"),
            std::string::npos)
      << refused("objects: [case]");
  EXPECT_NE(refused("objects: [drawr]").find("object 'drawr', which is no link of the file, expected one of"), std::string::npos);
}

/// Links may have names that objects cannot have.
TEST_F(UrdfScene, NamesOfObjects_AreMadeUsable) {
  std::string text = cell();
  for (std::size_t at = 0; (at = text.find("\"cube\"", at)) != std::string::npos;) text.replace(at, 6, "\"my/red cube\"");
  for (std::size_t at = 0; (at = text.find("\"knob\"", at)) != std::string::npos;) text.replace(at, 6, "\"my_red_cube\"");
  std::ofstream(dir_ / "odd.urdf") << text;
  const Scene scene = parse_scene("file: odd.urdf\nobjects: [my_red_cube_]", dir_);
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].name, "my_red_cube_");
  EXPECT_EQ(Model::make(scene)->objects().size(), 1u);
}

TEST_F(UrdfScene, FileWithoutMotors_IsThingsBesideARobot) {
  std::string text = cell();
  text.erase(text.find("<transmission"), text.find("</robot>") - text.find("<transmission"));
  std::ofstream(dir_ / "things.urdf") << text;
  const std::string message = message_of([&] { (void)parse_scene("file: things.urdf", dir_); });
  EXPECT_NE(message.find("got a file without a robot: no joint has an actuator"), std::string::npos) << message;
  const auto model = Model::make(
      parse_scene("file: things.urdf\nobjects: [drawer]\nrobots: [{name: arm, urdf: \"<robot name='a'><link name='l'/><link name='m'/>"
                  "<joint name='j' type='continuous'><parent link='l'/><child link='m'/></joint></robot>\"}]",
                  dir_));
  EXPECT_EQ(model->objects().size(), 1u);
  EXPECT_EQ(model->n_a(), 1);
}

/// Where it is one robot among others, a floating joint has no place.
TEST_F(UrdfScene, FloatingJointOfARobot_IsRefused) {
  const std::string message = message_of([&] { (void)parse_scene("robots: [{name: arm, urdf: cell.urdf}]", dir_); });
  EXPECT_NE(message.find("type 'floating', expected revolute, continuous, prismatic or fixed"), std::string::npos) << message;
}

}  // namespace
}  // namespace stiction::world
