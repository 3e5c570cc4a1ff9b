// Scenes that are in one MJCF file, compared with what MuJoCo makes of it.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "stiction/core/random.hpp"
#include "stiction/world/read.hpp"
#include "world/mjcf_oracle.hpp"

namespace stiction::world::test {
namespace {

namespace fs = std::filesystem;

/// An arm with a gripper whose fingers share a motor, a drawer in a case, a door with a latch on a spring, a lid with an off-centre anchor, a
/// puck in a plane, a pendulum on a ball, a cube, a table, and a lamp that only looks.
constexpr const char* kScene = R"(
<compiler angle="radian"/>
<worldbody>
  <geom name="floor" type="plane" size="1 1 1"/>
  <body name="pedestal" pos="0 -1 0.2"><geom name="post" type="box" size=".1 .1 .2"/>
    <body name="shoulder" pos="0 0 .3" euler="0 .2 0"><joint name="yaw" axis="0 0 1" range="-2 2"/><geom type="capsule" size=".04" fromto="0 0 0 .3 0 0"/>
      <body name="hand" pos=".3 0 0"><joint name="wrist" axis="0 1 0"/><geom type="box" size=".03 .05 .02"/>
        <body name="left" pos=".05 0 0"><joint name="l" type="slide" axis="0 1 0" range="0 .05"/><geom size=".01" pos=".02 .02 0"/></body>
        <body name="right" pos=".05 0 0"><joint name="r" type="slide" axis="0 1 0"/><geom size=".01" pos=".02 -.02 0"/></body>
  </body></body></body>
  <body name="case" pos="1 0 .3" euler="0 0 .7"><geom name="back" type="box" size=".02 .2 .2" pos=".2 0 0"/>
    <body name="drawer" pos="-.05 0 0"><joint name="rail" type="slide" axis="1 0 0" range="-.3 0" ref="-.1" damping="2" frictionloss=".4"/>
      <geom name="tray" type="box" size=".1 .1 .05"/><body name="knob" pos="-.1 0 0"><geom size=".02"/></body></body></body>
  <body name="frame" pos="0 1 .5"><geom name="jamb" type="box" size=".02 .02 .3" pos="-.3 0 0"/>
    <body name="door" pos="-.2 0 0" euler=".1 0 0"><joint name="hinge" axis="0 0 1" pos="-.05 .01 0" range="-1 2"/><geom type="box" size=".2 .02 .2" pos=".15 0 0"/>
      <body name="latch" pos=".3 -.05 0"><joint name="turn" axis="0 1 0" pos="0 0 .02" stiffness="1.5" springref=".2" range="-1 1"/><geom type="box" size=".05 .01 .01"/></body></body></body>
  <body name="puck" pos="0 2 .05" euler="0 0 .4"><joint name="px" type="slide" axis="1 0 0" ref=".1" damping=".3"/><joint name="py" type="slide" axis="0 1 0" damping=".3"/><joint name="pz" axis="0 0 -1" pos=".02 0 0" ref=".3" damping=".3"/>
    <geom type="cylinder" size=".05 .02" pos=".03 .01 0"/></body>
  <body name="bob" pos="2 0 1"><joint name="socket" type="ball" pos="0 0 .1"/><geom type="ellipsoid" size=".03 .04 .06" pos="0 0 -.2"/></body>
  <body name="cube" pos="0 -.5 .1" euler="0 0 .3"><joint type="free" damping=".01"/><geom name="die" type="box" size=".03 .04 .05"/></body>
  <body name="lamp" pos="0 0 2"><joint name="swing"/><geom size=".1" contype="0" conaffinity="0"/></body>
  <site name="goal" pos=".2 .3 .1" euler="0 0 .5"/>
</worldbody>
<equality><joint joint1="r" joint2="l" polycoef="0 -1 0 0 0"/></equality>
<contact><exclude body1="case" body2="drawer"/><exclude body1="puck" body2="world"/></contact>
<actuator><position joint="yaw" kp="100"/><position joint="wrist" kp="50"/><position joint="l" kp="400"/></actuator>
<keyframe><key name="open" qpos=".5 .1 .02 -.02 -.2 .7 .1 .3 -.2 .4 0.9689124 0.1 0.2 0.1 .1 .2 .3 1 0 0 0 0"/></keyframe>)";

fs::path write_scene() { return write_mjcf(kScene, "whole.xml"); }

Scene read(const std::string& extra = "") { return parse_scene(fmt::format("file: whole.xml\n{}", extra), write_scene().parent_path()); }

std::vector<std::string> names_of(const Scene& scene) {
  std::vector<std::string> out;
  for (const auto& object : scene.objects) out.push_back(object.name);
  return out;
}

TEST(WholeScene, PlanarBodyWithDifferentDampings_BecomesOneObjectPerJoint) {
  std::string text = kScene;
  text.replace(text.find("damping=\".3\"/>\n"), 12, "damping=\".2\"");
  const Scene scene = parse_scene("file: whole.xml", write_mjcf(text, "whole.xml").parent_path());
  for (const auto& [name, damping] : {std::pair{"puck.px", 0.3}, {"puck.py", 0.3}, {"puck", 0.2}}) {
    const auto found = std::find_if(scene.objects.begin(), scene.objects.end(), [&](const ObjectSpec& o) { return o.name == name; });
    ASSERT_NE(found, scene.objects.end()) << name;
    EXPECT_EQ(found->joint_damping, damping) << name;
  }
}

std::string refused(const std::string& extra, const std::string& content = kScene) {
  const fs::path file = write_mjcf(content, "whole.xml");
  return stiction::test::message_of([&] { (void)parse_scene(fmt::format("file: whole.xml\n{}", extra), file.parent_path()); });
}

TEST(WholeScene, TreesWithActuators_AreTheRobotAndOthersObjects) {
  const Scene scene = read();
  ASSERT_EQ(scene.robots.size(), 1u);
  EXPECT_EQ(scene.robots[0].contents->robot.movable_joints(), (std::vector<std::string>{"yaw", "wrist", "l"}));
  EXPECT_EQ(names_of(scene), (std::vector<std::string>{"drawer", "door", "latch", "puck", "bob.socket_z", "bob.socket_y", "bob", "cube"}));
  const auto object = [&](const std::string& name) {
    return *std::find_if(scene.objects.begin(), scene.objects.end(), [&](const ObjectSpec& o) { return o.name == name; });
  };
  EXPECT_EQ(object("drawer").joint, ObjectJoint::Slider);
  EXPECT_EQ(object("drawer").joint_friction, 0.4);
  EXPECT_EQ(object("drawer").joint_damping, 2);
  EXPECT_EQ((*object("drawer").limits)[0], -0.3);
  EXPECT_EQ(object("drawer").geometries.size(), 2u) << "with the knob";
  EXPECT_EQ(object("latch").parent, "door");
  EXPECT_EQ(object("latch").joint_stiffness, 1.5);
  EXPECT_EQ(object("latch").joint_rest, 0.2);
  EXPECT_EQ(object("puck").joint, ObjectJoint::PlanarXZ) << "it turns about −z";
  EXPECT_EQ(object("puck").joint_damping, 0.3);
  EXPECT_EQ(object("cube").joint_damping, 0.01);
  ASSERT_EQ(scene.fixed.size(), 1u);
  std::set<std::string> fixed;
  for (const auto& geometry : scene.fixed[0].geometries) fixed.insert(geometry.name);
  EXPECT_EQ(fixed, (std::set<std::string>{"floor", "case.back", "frame.jamb"})) << "the pedestal is a link, as the robot hangs on it";
}

/// Every body stands where MuJoCo has it when all joints are moved at random, and the masses are those of MuJoCo.
TEST(WholeScene, ObjectsAndLinks_StandWhereMujocoHasThem) {
  const auto model = Model::make(read());
  const Owned<mjModel> m = load_mujoco(write_scene());
  const Owned<mjData> d(mj_makeData(m.get()));
  core::Random random(3, 1);
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  const auto joint = [&](const char* name) { return d->qpos + m->jnt_qposadr[mj_name2id(m.get(), mjOBJ_JOINT, name)]; };
  const auto q_of = [&](const char* name) { return model->objects()[static_cast<std::size_t>(model->object_index(name))].q_begin; };
  for (int sample = 0; sample < 20; ++sample) {
    for (int i = 0; i < m->nq; ++i) d->qpos[i] = sample == 0 ? m->qpos0[i] : random.normal();
    apply_equalities(m.get(), d.get());
    mj_normalizeQuat(m.get(), d->qpos);
    mj_kinematics(m.get(), d.get());
    Eigen::VectorXd q = model->neutral();
    for (const auto& [object, name] : {std::pair{"drawer", "rail"}, {"door", "hinge"}, {"latch", "turn"}}) q[q_of(object)] = *joint(name);
    q.segment<3>(q_of("puck")) << *joint("px"), *joint("py"), *joint("pz");
    const mjtNum* ball = joint("socket");
    const Eigen::Vector3d zyx = Eigen::Quaterniond(ball[0], ball[1], ball[2], ball[3]).toRotationMatrix().eulerAngles(2, 1, 0);
    q[q_of("bob.socket_z")] = zyx[0], q[q_of("bob.socket_y")] = zyx[1], q[q_of("bob")] = zyx[2];
    const int cube = mj_name2id(m.get(), mjOBJ_BODY, "cube");
    const mjtNum* free = d->qpos + m->jnt_qposadr[m->body_jntadr[cube]];
    q.segment<7>(q_of("cube")) << free[0], free[1], free[2], free[4], free[5], free[6], free[3];
    for (const char* name : {"yaw", "wrist", "l"}) q[model->n_qu() + model->joint_index(name)] = *joint(name);
    calc_kinematics(*model, q, work, kinematics);
    for (int g = 0; g < m->ngeom; ++g) {
      if ((m->geom_contype[g] | m->geom_conaffinity[g]) == 0) continue;
      const Pose X_WG = pose_of(d->geom_xpos + 3 * g, d->geom_xmat + 9 * g);
      const bool there = std::any_of(model->geometries().begin(), model->geometries().end(), [&](const Geometry& geometry) {
        return distance(kinematics.X_WB[static_cast<std::size_t>(geometry.body)] * geometry.X_BG, X_WG) < 1e-9;
      });
      EXPECT_TRUE(there) << "geom " << g << " of body " << body_name(m.get(), m->geom_bodyid[g]) << " in sample " << sample;
    }
    for (const char* name : {"drawer", "door", "latch", "puck", "bob", "cube"}) {
      const auto& object = model->objects()[static_cast<std::size_t>(model->object_index(name))];
      const int body = mj_name2id(m.get(), mjOBJ_BODY, name);
      double mass = m->body_mass[body];
      Eigen::Vector3d moment = mass * Eigen::Map<const Eigen::Vector3d>(d->xipos + 3 * body);
      if (std::string(name) == "drawer") {
        const int knob = mj_name2id(m.get(), mjOBJ_BODY, "knob");
        mass += m->body_mass[knob];
        moment += m->body_mass[knob] * Eigen::Map<const Eigen::Vector3d>(d->xipos + 3 * knob);
      }
      EXPECT_NEAR(object.mass / mass, 1, 3e-6) << name;
      const auto at = static_cast<std::size_t>(object.body);
      EXPECT_LT((kinematics.X_WB[at] * model->inertias()[at].p_BCom - moment / mass).norm(), 1e-7) << name;
    }
    if (testing::Test::HasFailure()) return;
  }
}

TEST(WholeScene, KeyframesSitesAndThePoseOfTheFile_AreRead) {
  const Scene scene = read();
  const RobotContents& contents = *scene.robots[0].contents;
  const auto q_of = [](const FileConfiguration& c, const std::string& name) {
    return std::find_if(c.objects.begin(), c.objects.end(), [&](const auto& entry) { return entry.first == name; })->second;
  };
  EXPECT_EQ(q_of(contents.as_written, "drawer")[0], -0.1);
  EXPECT_EQ(q_of(contents.as_written, "puck"), Eigen::Vector3d(0.1, 0, 0.3));
  ASSERT_EQ(contents.keyframes.size(), 1u);
  const FileConfiguration& open = contents.keyframes[0];
  EXPECT_EQ(open.name, "open");
  EXPECT_EQ(q_of(open, "drawer")[0], -0.2);
  EXPECT_EQ(q_of(open, "door")[0], 0.7);
  EXPECT_EQ(open.joints[0], (std::pair<std::string, double>{"yaw", 0.5}));
  const auto goal = std::find_if(contents.places.begin(), contents.places.end(), [](const FilePlace& p) { return p.name == "goal"; });
  ASSERT_NE(goal, contents.places.end());
  EXPECT_EQ(goal->X_WF.p, Eigen::Vector3d(0.2, 0.3, 0.1));
  EXPECT_TRUE(goal->moved_by.empty());
  const auto knob = std::find_if(contents.places.begin(), contents.places.end(), [](const FilePlace& p) { return p.name == "knob"; });
  EXPECT_EQ(knob->moved_by, "drawer");
}

/// Of each keyframe of a file, every geom that collides stands where MuJoCo has it.
void expect_keyframes_as_in_mujoco(const fs::path& file) {
  const auto model = Model::make(parse_scene(fmt::format("file: {}", file.filename().string()), file.parent_path()));
  const Owned<mjModel> m = load_mujoco(file);
  const Owned<mjData> d(mj_makeData(m.get()));
  const auto& keyframes = model->scene().robots[0].contents->keyframes;
  ASSERT_EQ(static_cast<int>(keyframes.size()), m->nkey);
  for (int key = 0; key < m->nkey; ++key) {
    const FileConfiguration& at = keyframes[static_cast<std::size_t>(key)];
    Eigen::VectorXd q = model->neutral();
    for (const auto& [object, value] : at.objects)
      q.segment(model->objects()[static_cast<std::size_t>(model->object_index(object))].q_begin, value.size()) = value;
    for (const auto& [joint, value] : at.joints) q[model->n_qu() + model->joint_index(joint)] = value;
    mj_resetDataKeyframe(m.get(), d.get(), key);
    mj_kinematics(m.get(), d.get());
    KinematicsWorkspace work(*model);
    Kinematics kinematics;
    calc_kinematics(*model, q, work, kinematics);
    for (int g = 0; g < m->ngeom; ++g) {
      const Pose X_WG = pose_of(d->geom_xpos + 3 * g, d->geom_xmat + 9 * g);
      EXPECT_TRUE(std::ranges::any_of(model->geometries(),
                                      [&](const Geometry& geometry) {
                                        return distance(kinematics.X_WB[static_cast<std::size_t>(geometry.body)] * geometry.X_BG, X_WG) <
                                               1e-7;
                                      }))
          << "geom " << g << " in keyframe " << key;
    }
  }
}

std::string key_of(const std::vector<double>& qpos) {
  std::string out;
  for (const double x : qpos) out += fmt::format("{:.17g} ", x);
  return fmt::format("<key qpos='{}'/>", out);
}

/// A ball anywhere, also where its second hinge stands upright and the others turn about the same axis.
TEST(WholeScene, BallJoints_StandWhereMujocoHasThem) {
  const double half = std::sqrt(0.5);
  const Eigen::Quaterniond upright(half, 0, half, 0), down(half, 0, -half, 0), turned(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond tiny(Eigen::AngleAxisd(1e-9, Eigen::Vector3d::UnitX())),
      large(Eigen::AngleAxisd(3.1, Eigen::Vector3d(0.6, 0, 0.8))), rolled(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()));
  std::string keys;
  for (const Eigen::Quaterniond& R :
       {Eigen::Quaterniond::Identity(), tiny, large, upright, down, turned * upright, rolled * down, turned * upright * rolled})
    keys += key_of({0.3, R.w(), R.x(), R.y(), R.z()});
  const fs::path file = write_mjcf(
      R"(<worldbody><body name="r"><joint name="j"/><geom size=".1"/></body><body name="knob" pos="1 0 0" euler="10 20 30"><joint name="b" type="ball" pos=".1 0 0"/>
      <geom type="box" size=".1 .2 .3"/></body></worldbody><actuator><motor joint="j"/></actuator><keyframe>)" +
          keys + "</keyframe>",
      "ball.xml");
  expect_keyframes_as_in_mujoco(file);
  const auto notes = read_mjcf(file).robot.notes;
  EXPECT_TRUE(std::ranges::any_of(
      notes, [](const auto& n) { return n.starts_with("ball joints are hinges about z, y and x") && n.ends_with(": b"); }));
}

/// A free box with a lid on a hinge, on which a knob hangs on a ball and a bolt on a slide.
TEST(WholeScene, ChainsOnAFreeBody_StandWhereMujocoHasThem) {
  core::Random random(8, 1);
  std::string keys;
  for (int k = 0; k < 10; ++k) {
    std::vector<double> qpos(1 + 7 + 1 + 4 + 1);
    for (double& x : qpos) x = random.normal();
    keys += key_of(qpos);
  }
  expect_keyframes_as_in_mujoco(write_mjcf(
      R"(<worldbody><body name="r" pos="0 0 2"><joint name="j"/><geom size=".1"/></body>
      <body name="box" pos="1 0 0"><freejoint/><geom type="box" size=".1 .2 .3"/>
        <body name="lid" pos="0 0 .3" euler="0 30 0"><joint axis="0 1 .2" pos="-.1 0 0" ref="15"/><geom type="box" size=".1 .2 .01"/>
          <body name="knob" pos=".1 0 0"><joint type="ball" pos="0 0 -.02"/><geom type="capsule" size=".02 .03"/></body>
          <body name="bolt" pos="-.1 0 0"><joint type="slide" axis="0 1 0"/><geom type="cylinder" size=".01 .05"/></body></body></body></worldbody>
      <actuator><motor joint="j"/></actuator><keyframe>)" +
          keys + "</keyframe>",
      "chain.xml"));
}

TEST(WholeScene, NamedObjects_AreTheOnlyOnes) {
  const Scene scene = read("objects: [drawer, {name: ball, joint: free, mass: 1, shapes: [{sphere: {radius: 0.1}}]}]\n");
  EXPECT_EQ(names_of(scene), (std::vector<std::string>{"drawer", "ball"}));
  std::set<std::string> fixed;
  for (const auto& geometry : scene.fixed[0].geometries) fixed.insert(geometry.name);
  EXPECT_TRUE(fixed.contains("cube.die")) << "what is not named stands still";
}

TEST(WholeScene, PairsThatTheFileExcludes_NeverTouch) {
  const auto model = Model::make(read());
  for (const auto& pair : model->pairs()) {
    const std::set<std::string> names{model->geometries()[static_cast<std::size_t>(pair.geometry_a)].name,
                                      model->geometries()[static_cast<std::size_t>(pair.geometry_b)].name};
    EXPECT_FALSE(names.contains("drawer/tray") && names.contains("robot_world/case.back"));
    EXPECT_FALSE(names.contains("puck/cylinder_0") && names.contains("robot_world/floor"));
  }
}

TEST(WholeScene, RobotKeys_NameItAndChangeIt) {
  const Scene scene = read("robot: {name: arm, stiffness: {yaw: 7}, effort: 3}\ngravity: [0, 0, -2]\n");
  EXPECT_EQ(scene.robots[0].name, "arm");
  const auto model = Model::make(scene);
  EXPECT_EQ(model->stiffness()[model->joint_index("arm/yaw")], 7);
  EXPECT_EQ(scene.gravity[2], -2);
}

TEST(WholeScene, BadInput_IsNamed) {
  EXPECT_NE(refused("objects: [drawr]").find("object 'drawr', which is no body of the file"), std::string::npos)
      << refused("objects: [drawr]");
  EXPECT_NE(refused("objects: [drawr]").find("did you mean 'drawer'?"), std::string::npos);
  EXPECT_NE(refused("objects: [case]").find("body 'case' as object, which no joint moves"), std::string::npos);
  EXPECT_NE(refused("objects: [hand]").find("object 'hand', which hangs on a joint of the robot"), std::string::npos);
  EXPECT_NE(refused("robot: {bodies: [case]}").find("body 'case' as robot, which no joint moves"), std::string::npos);
  EXPECT_NE(refused("robot: {mjcf: a.xml}").find("unknown key"), std::string::npos);
  const std::string nothing = R"(<worldbody><body><joint/><geom size=".1"/></body></worldbody>)";
  EXPECT_NE(refused("", nothing).find("got a file without a robot: no joint has an actuator"), std::string::npos) << refused("", nothing);
  const std::string loop = R"(<include file="whole.xml"/>)";
  EXPECT_NE(refused("", loop).find("a file that MuJoCo compiles"), std::string::npos) << refused("", loop);
  const auto message = stiction::test::message_of([] { (void)parse_scene("objects: [drawer]", "."); });
  EXPECT_NE(message.find("a name stands for a body of `file`, and there is none"), std::string::npos) << message;
}

TEST(WholeScene, RobotWithoutActuators_IsNamedByABodyOfItsTree) {
  const fs::path file = write_mjcf(R"(<worldbody><body name="base"><joint name="j"/><geom size=".1"/></body>
      <body name="box" pos="1 0 0"><freejoint/><geom size=".1"/></body></worldbody>)",
                                   "bare.xml");
  const Scene scene = parse_scene("file: bare.xml\nrobot: {bodies: [base]}", file.parent_path());
  EXPECT_EQ(scene.robots[0].contents->robot.movable_joints(), (std::vector<std::string>{"j"}));
  EXPECT_EQ(names_of(scene), (std::vector<std::string>{"box"}));
}

TEST(WholeScene, FreeBase_StandsStillWhereAsked) {
  const fs::path file = write_mjcf(R"(<worldbody><body name="torso" pos="0 0 1"><freejoint/><geom size=".1"/>
      <body name="arm"><joint name="j"/><geom size=".05" pos=".3 0 0"/></body></body></worldbody><actuator><motor joint="j"/></actuator>)",
                                   "floating.xml");
  const auto message = stiction::test::message_of([&] { (void)parse_scene("file: floating.xml", file.parent_path()); });
  EXPECT_NE(message.find("a joint on a body with a free joint; fixed_base: true makes that stand still"), std::string::npos) << message;
  const Scene scene = parse_scene("file: floating.xml\nrobot: {fixed_base: true}", file.parent_path());
  EXPECT_EQ(scene.robots[0].contents->robot.movable_joints(), (std::vector<std::string>{"j"}));
  const auto model = Model::make(scene);
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  calc_kinematics(*model, model->neutral(), work, kinematics);
  EXPECT_EQ(kinematics.X_WB[static_cast<std::size_t>(body_index(*model, "robot/torso"))].p, Eigen::Vector3d(0, 0, 1));
}

/// What only looks may miss its mesh; what collides may not.
TEST(WholeScene, MissingFiles_AreLeftOutWhereTheyAreOnlySeen) {
  const std::string assets =
      R"(<asset><mesh name="skin" file="nowhere.stl"/><texture name="t" type="2d" file="nowhere.png"/><material name="m" texture="t"/></asset>)";
  const auto body = [](const char* geom) {
    return fmt::format(R"(<worldbody><body name="b"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="j"/>
      <geom type="mesh" mesh="skin" {} material="m"/><geom size=".1"/></body></worldbody>)",
                       geom);
  };
  const fs::path file = write_mjcf(assets + body(R"(contype="0" conaffinity="0")"), "skin.xml");
  const RobotContents contents = read_mjcf(file);
  const auto& notes = contents.robot.notes;
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const auto& n) { return n.find("meshes whose files are missing") == 0; }));
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const auto& n) { return n.find("textures whose files are missing") == 0; }));
  EXPECT_EQ(contents.robot.links[1].collisions.size(), 1u);
  const std::string message = message_of_file(write_mjcf(assets + body(""), "skin.xml"));
  EXPECT_NE(message.find("nowhere.stl"), std::string::npos) << message;
}

/// Six pictures, whose names MuJoCo does not tell; another fault of the file is named all the same.
TEST(WholeScene, MissingPicturesOfACube_AreLeftOut) {
  const std::string cube =
      R"(<asset><texture name="dice" type="cube" fileup="u.png" filedown="d.png" fileleft="l.png" fileright="r.png" filefront="f.png" fileback="b.png"/>
      <material name="m" texture="dice"/>{}</asset><worldbody><body name="b"><joint name="j"/><geom size=".1" material="m"/></body></worldbody>)";
  const RobotContents contents = read_mjcf(write_mjcf(fmt::format(fmt::runtime(cube), ""), "cube.xml"));
  const auto& notes = contents.robot.notes;
  EXPECT_TRUE(
      std::any_of(notes.begin(), notes.end(), [](const auto& n) { return n.find("textures of cubes") == 0 && n.ends_with("dice"); }));
  EXPECT_EQ(contents.robot.links[1].collisions.size(), 1u);
  const std::string message =
      message_of_file(write_mjcf(fmt::format(fmt::runtime(cube), R"(<material name="n" texture="none"/>)"), "cube.xml"));
  EXPECT_NE(message.find("none"), std::string::npos) << message;
}

TEST(WholeScene, AnglesThatLookLikeRadians_AreNamedWhereTheFileDoesNotSay) {
  const std::string body = R"(<worldbody><body><joint name="hinge" range="0 0.4"/><geom size=".1"/></body></worldbody>)";
  const auto has_note = [](const fs::path& file) {
    const auto& notes = read_mjcf(file).robot.notes;
    return std::any_of(notes.begin(), notes.end(), [](const auto& n) { return n.find("hinge [0, 0.4]") != std::string::npos; });
  };
  EXPECT_TRUE(has_note(write_mjcf(body, "angles.xml")));
  EXPECT_FALSE(has_note(write_mjcf(R"(<compiler angle="degree"/>)" + body, "angles.xml")));
  write_mjcf(R"(<compiler angle="radian"/>)", "units.xml");
  EXPECT_FALSE(has_note(write_mjcf(R"(<include file="units.xml"/>)" + body, "angles.xml")));
}

/// A tendon pulls with 2·kp·(c₁² + c₂²)… on two joints; they turn together.
TEST(WholeScene, JointsOnATendonWithAnActuator_MoveTogether) {
  const fs::path file = write_mjcf(
      R"(<worldbody><body><joint name="a"/><geom size=".1"/><body pos=".3 0 0"><joint name="b"/><geom size=".1"/></body></body></worldbody>
      <tendon><fixed name="t"><joint joint="a" coef="1"/><joint joint="b" coef=".5"/></fixed></tendon>
      <actuator><position tendon="t" kp="10" forcerange="-2 2"/></actuator>)",
      "tendon.xml");
  const RobotContents contents = read_mjcf(file);
  EXPECT_EQ(contents.robot.movable_joints(), (std::vector<std::string>{"a"}));
  EXPECT_EQ(contents.robot.joints[1].ratio, 0.5);
  EXPECT_DOUBLE_EQ(*contents.robot.joints[0].stiffness, 10 * 1.25 * 1.25) << "the length changes by 1 + 0.5² per turn of a";
  EXPECT_DOUBLE_EQ(*contents.robot.joints[0].effort, 2 * 1.25);
}

TEST(WholeScene, FiveHundredBodies_LoadAndSayWhatTheyCost) {
  const fs::path file = write_mjcf(R"(<worldbody><body name="r" pos="0 0 5"><joint name="j"/><geom size=".1"/></body>
      <replicate count="500" offset=".3 0 0"><body name="ball"><freejoint/><geom size=".1"/></body></replicate></worldbody><actuator><motor joint="j"/></actuator>)",
                                   "many.xml");
  const auto model = Model::make(parse_scene("file: many.xml", file.parent_path()));
  EXPECT_EQ(model->objects().size(), 500u);
  const auto notes = model->notes();
  const std::string cost = fmt::format("502 bodies, of which {} pairs of shapes may touch", 500 * 499 / 2 + 500);
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [&](const auto& note) { return note.find(cost) != std::string::npos; }))
      << notes.back();
}

/// A lever of 0.1 kg at 0.2 m: its weight turns it at 0.1·9.81·0.2/D through its damping D.
TEST(WholeScene, LeverThatDampingAloneHolds_StaysWhereItIsLeft) {
  const auto lever = [](double damping, const char* more = "") {
    write_mjcf(
        fmt::format(
            R"(<worldbody><body name="r"><joint name="j"/><geom size=".1"/></body><body name="lever" pos="1 0 0"><joint axis="0 1 0" damping="{}" {}/>
      <geom type="sphere" size=".02" mass=".1" pos=".2 0 0"/></body></worldbody><actuator><motor joint="j"/></actuator>)",
            damping, more),
        "lever.xml");
    return parse_scene("file: lever.xml", stiction::test::folder_of_the_process()).objects[0].joint_friction;
  };
  EXPECT_NEAR(lever(20), 1.5 * 0.1 * 9.81 * 0.2, 1e-9) << "0.01 rad/s";
  EXPECT_EQ(lever(5), 0) << "0.04 rad/s: it falls";
  EXPECT_EQ(lever(20, R"(stiffness="3")"), 0) << "a spring holds it";
  EXPECT_EQ(lever(20, R"(frictionloss=".5")"), 0.5);
}

TEST(WholeScene, PolynomialEquality_BecomesTheNearestLineAndSaysHowFarOff) {
  const fs::path file = write_mjcf(
      R"(<compiler angle="radian"/><worldbody><body><joint name="a" range="0 1"/><geom size=".1"/><body pos=".3 0 0"><joint name="b"/><geom size=".1"/></body></body></worldbody>
      <equality><joint joint1="b" joint2="a" polycoef="0 0 1 0 0"/></equality>)",
      "curve.xml");
  const RobotContents contents = read_mjcf(file);
  const RobotJoint& b = contents.robot.joints[1];
  EXPECT_NEAR(b.ratio, 1, 1e-9) << "of x² over [0, 1] the line x − 1/8";
  EXPECT_NEAR(b.offset, -1.0 / 8, 1e-9);
  const auto& notes = contents.robot.notes;
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const auto& n) {
    return n.find("nearest line, which is off by at most [rad, m]: b 0.125") != std::string::npos;
  }));
}

}  // namespace
}  // namespace stiction::world::test
