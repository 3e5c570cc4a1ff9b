// Grippers on arms: links stand where the transform of the flange and that of the gripper's own file have them.
#include <algorithm>
#include <fstream>

#include "stiction/core/random.hpp"
#include "stiction/world/read.hpp"
#include "world/mjcf_oracle.hpp"

namespace stiction::world::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kArm = R"(<compiler angle="radian"/><worldbody><body name="base"><geom size=".1"/>
  <body name="link1" pos="0 0 .3"><joint name="j1" axis="0 0 1"/><geom type="capsule" size=".04" fromto="0 0 0 .3 0 0"/>
  <body name="flange" pos=".3 0 0" euler="0 .3 0"><joint name="j2" axis="0 1 0"/><geom size=".03"/></body>
  <body name="camera" pos="0 .1 0"><geom size=".02"/></body></body></body></worldbody><actuator><position joint="j1" kp="10"/><position joint="j2" kp="20"/></actuator>)";
constexpr const char* kGripper =
    R"(<compiler angle="radian"/><worldbody><body name="palm" pos="0 0 .02"><geom type="box" size=".02 .04 .02"/>
  <body name="left" pos="0 .02 .03"><joint name="open" type="slide" axis="0 1 0" range="0 .04"/><geom name="tip" size=".01"/></body>
  <body name="right" pos="0 -.02 .03"><joint name="mirror" type="slide" axis="0 -1 0"/><geom size=".01"/></body></body></worldbody>
  <equality><joint joint1="mirror" joint2="open" polycoef="0 1 0 0 0"/></equality><contact><exclude body1="left" body2="right"/></contact>
  <actuator><position joint="open" kp="300"/></actuator>)";
constexpr const char* kUrdf =
    R"(<robot name="finger"><link name="stem"/><link name="tip"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="bend" type="revolute"><parent link="stem"/><child link="tip"/><origin xyz="0 0 0.05"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="2"/></joint></robot>)";

class Mounted : public testing::Test {
 protected:
  void SetUp() override {
    dir_ = write_mjcf(kArm, "arm.xml").parent_path();
    write_mjcf(kGripper, "gripper.xml");
    std::ofstream(dir_ / "finger.urdf") << kUrdf;
  }
  Scene scene(const std::string& mount, const std::string& robot = "mjcf: arm.xml") const {
    return parse_scene("robots: [{name: r, " + robot + ", mount: " + mount + "}]", dir_);
  }
  std::string refused(const std::string& mount) const {
    return stiction::test::message_of([&] { (void)scene(mount); });
  }
  fs::path dir_;
};

/// A pair of the gripper's own is one of what it became; one with its world, which is left out, is none.
TEST_F(Mounted, ContactPairs_KeepTheirFriction) {
  write_mjcf(R"(<worldbody><geom name="bench" type="plane" size="1 1 1"/><body name="palm"><geom name="hull" size=".02"/>
      <body name="left" pos="0 .011 0"><joint/><geom name="a" size=".01"/></body><body name="right" pos="0 -.011 0"><joint/><geom name="b" size=".01"/></body></body></worldbody>
      <contact><pair geom1="b" geom2="a" condim="6" friction=".7 .7 .03 .002 .002"/><pair geom1="bench" geom2="a"/></contact>)",
             "pads.xml");
  const auto model = Model::make(scene("{name: g, file: pads.xml, on: flange}"));
  int found = 0;
  for (const Pair& pair : model->pairs()) {
    const auto name = [&](int geometry) { return model->geometries()[static_cast<std::size_t>(geometry)].name; };
    const bool own = name(pair.geometry_a) == "r/g_left/a" && name(pair.geometry_b) == "r/g_right/b";
    found += own;
    EXPECT_EQ(pair.torsional, own ? 0.03 : 0);
    EXPECT_EQ(pair.rolling, own ? 0.002 : 0);
    EXPECT_EQ(pair.friction, own ? 0.7 : 1);
  }
  EXPECT_EQ(found, 1);
}

TEST_F(Mounted, GripperOnAFlange_StandsWhereMujocoAttachesIt) {
  const auto model = Model::make(scene("{file: gripper.xml, on: flange, pose: {position: [0.02, 0, 0.01], rpy: [0, 0, 0.5]}}"));
  ASSERT_EQ(model->n_a(), 3);
  ASSERT_EQ(model->followers().size(), 1u);
  // The oracle: MuJoCo's own attachment of the gripper's body to a frame in the flange.
  const fs::path both = write_mjcf(
      R"(<compiler angle="radian"/><asset><model name="g" file="gripper.xml"/></asset><worldbody><body name="base"><geom size=".1"/>
    <body name="link1" pos="0 0 .3"><joint name="j1" axis="0 0 1"/><geom type="capsule" size=".04" fromto="0 0 0 .3 0 0"/>
    <body name="flange" pos=".3 0 0" euler="0 .3 0"><joint name="j2" axis="0 1 0"/><geom size=".03"/>
      <frame pos=".02 0 .01" euler="0 0 .5"><attach model="g" body="palm" prefix=""/></frame></body></body></body></worldbody>)",
      "both.xml");
  const Owned<mjModel> m = load_mujoco(both);
  ASSERT_NE(m, nullptr);
  const Owned<mjData> d(mj_makeData(m.get()));
  core::Random random(2, 1);
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  for (int sample = 0; sample < 10; ++sample) {
    Eigen::VectorXd q = model->neutral();
    const auto set = [&](const char* joint, double value) {
      d->qpos[m->jnt_qposadr[mj_name2id(m.get(), mjOBJ_JOINT, joint)]] = value;
      if (std::string(joint) != "mirror") q[model->joint_index(joint)] = value;
    };
    const double open = random.uniform(0, 0.04);
    set("j1", random.normal()), set("j2", random.normal()), set("open", open), set("mirror", open);
    mj_kinematics(m.get(), d.get());
    calc_kinematics(*model, q, work, kinematics);
    for (const char* body : {"palm", "left", "right", "flange"}) {
      const int b = mj_name2id(m.get(), mjOBJ_BODY, body);
      const int index = body_index(*model, std::string("r/") + body);
      ASSERT_GE(index, 0) << body;
      EXPECT_LT(distance(kinematics.X_WB[static_cast<std::size_t>(index)], pose_of(d->xpos + 3 * b, d->xmat + 9 * b)), 1e-9) << body;
    }
  }
}

TEST_F(Mounted, UrdfOnMjcfAndMjcfOnUrdf_AnyDepth) {
  const Scene mixed = scene("[{file: gripper.xml, on: flange}, {name: f, file: finger.urdf, on: left, pose: {position: [0, 0, 0.1]}}]");
  EXPECT_EQ(mixed.robots[0].contents->robot.movable_joints(), (std::vector<std::string>{"j1", "j2", "open", "f_bend"}));
  const auto model = Model::make(mixed);
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  calc_kinematics(*model, model->neutral(), work, kinematics);
  const auto at = [&](const char* body) { return kinematics.X_WB[static_cast<std::size_t>(body_index(*model, body))]; };
  EXPECT_LT(((at("r/left").inverse() * at("r/f_tip")).p - Eigen::Vector3d(0, 0, 0.15)).norm(), 1e-12);
  EXPECT_EQ(at("r/camera").p, Eigen::Vector3d(0, 0.1, 0.3)) << "what comes after the flange in the file is still there";
  const Scene other = scene("{file: gripper.xml, on: tip, name: g}", "urdf: finger.urdf");
  EXPECT_EQ(other.robots[0].contents->robot.movable_joints(), (std::vector<std::string>{"bend", "g_open"}));
}

TEST_F(Mounted, PairsStiffnessAndDigest_KnowTheMountedFile) {
  const Scene with = scene("{file: gripper.xml, on: flange}, stiffness: {open: 77}, push_with: [left, right]");
  const auto model = Model::make(with);
  EXPECT_EQ(model->stiffness()[model->joint_index("open")], 77);
  for (const auto& pair : model->pairs()) {
    const auto body = [&](int g) {
      return model->bodies()[static_cast<std::size_t>(model->geometries()[static_cast<std::size_t>(g)].body)].name;
    };
    EXPECT_FALSE(body(pair.geometry_a) == "r/left" && body(pair.geometry_b) == "r/right") << "its file excludes them";
    EXPECT_FALSE(body(pair.geometry_a) == "r/flange" && body(pair.geometry_b) == "r/palm") << "they are welded";
  }
  const Scene without = parse_scene("robots: [{name: r, mjcf: arm.xml}]", dir_);
  EXPECT_NE(with.robots[0].contents->sha256, without.robots[0].contents->sha256);
}

TEST_F(Mounted, BadInput_IsNamed) {
  const std::string missing = refused("{file: gripper.xml, on: flang}");
  EXPECT_NE(missing.find("robots[0].mount: mount[0].on: got unknown link 'flang', expected one of"), std::string::npos) << missing;
  EXPECT_NE(missing.find("did you mean 'flange'?"), std::string::npos);
  EXPECT_NE(refused("{file: nowhere.xml, on: flange}").find("'nowhere.xml', which does not exist"), std::string::npos);
  EXPECT_NE(refused("[{file: gripper.xml, on: flange}, {file: gripper.xml, on: link1}]").find("mount[1].name: got link"), std::string::npos)
      << refused("[{file: gripper.xml, on: flange}, {file: gripper.xml, on: link1}]");
  write_mjcf(R"(<worldbody><body name="ball"><freejoint/><geom size=".1"/></body></worldbody>)", "ball.xml");
  EXPECT_NE(refused("{file: ball.xml, on: flange}").find("with the object 'ball', expected a file with a robot alone"), std::string::npos);
  EXPECT_NE(refused("{file: gripper.xml, on: flange, at: 3}").find("unknown key"), std::string::npos);
}

}  // namespace
}  // namespace stiction::world::test
