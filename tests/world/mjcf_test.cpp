#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "world/mjcf_oracle.hpp"

namespace stiction::world::test {
namespace {

namespace fs = std::filesystem;

fs::path data(const std::string& name) { return source_dir() / "tests/world/data" / name; }

std::string refused_mjcf(const std::string& content) {
  const std::string message = message_of_file(write_mjcf(content));
  const auto at = message.find("mjcf: ");
  return at == std::string::npos ? message : message.substr(at);
}

TEST(Mjcf, OddModel_StandsWhereMujocoHasIt) { compare_kinematics(data("odd.xml")); }

TEST(Mjcf, OddModel_HasTheJointsStiffnessesAndObjectsOfTheFile) {
  const RobotContents odd = read_mjcf(data("odd.xml"));
  EXPECT_EQ(odd.robot.name, "odd");
  EXPECT_EQ(odd.robot.movable_joints(), (std::vector<std::string>{"lift", "yaw", "pitch", "elbow", "finger_joint_0"}));
  const auto joint = [&](const std::string& name) {
    return *std::find_if(odd.robot.joints.begin(), odd.robot.joints.end(), [&](const RobotJoint& j) { return j.name == name; });
  };
  EXPECT_DOUBLE_EQ(*joint("lift").stiffness, 500);
  EXPECT_DOUBLE_EQ(*joint("yaw").stiffness, 20 * 9) << "k_p g²";
  EXPECT_DOUBLE_EQ(*joint("pitch").stiffness, 40) << "of its class";
  EXPECT_DOUBLE_EQ(*joint("elbow").stiffness, 7) << "the motor beside it holds nothing";
  EXPECT_FALSE(joint("finger_joint_0").stiffness.has_value());
  EXPECT_NEAR(joint("elbow").upper, 120 * M_PI / 180, 1e-12) << "class and degrees";
  EXPECT_NEAR(joint("yaw").lower, -M_PI / 2, 1e-12);
  EXPECT_EQ(joint("lift").lower, -0.1);
  ASSERT_EQ(odd.objects.size(), 2u);
  EXPECT_EQ(odd.objects[0].name, "cube");
  EXPECT_NEAR(odd.objects[0].mass, 0.4, 1e-12);
  EXPECT_EQ(odd.objects[0].geometries.size(), 2u) << "the welded knob belongs to it";
  EXPECT_EQ(odd.objects[0].geometries[1].name, "knob.sphere_0");
  ASSERT_EQ(odd.fixed.size(), 3u);
  EXPECT_EQ(odd.fixed[0].friction, 0.5);
  EXPECT_TRUE(std::any_of(odd.fixed.begin(), odd.fixed.end(), [](const auto& g) { return g.name == "pedestal.ramp"; }));
  EXPECT_EQ(odd.excludes.size(), 2u);
}

/// The whole object turns about its centre of mass as MuJoCo's body does.
TEST(Mjcf, ObjectOfSeveralBodies_HasTheInertiaOfAll) {
  const RobotContents odd = read_mjcf(data("odd.xml"));
  const Owned<mjModel> m = load_mujoco(data("odd.xml"));
  const Owned<mjData> d(mj_makeData(m.get()));
  mj_fwdPosition(m.get(), d.get());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(m->nv, m->nv);
  mj_fullM(m.get(), d.get(), M.data());
  const int v = m->jnt_dofadr[m->body_jntadr[mj_name2id(m.get(), mjOBJ_BODY, "cube")]];
  const Eigen::Matrix3d about_origin = M.block<3, 3>(v + 3, v + 3);
  const int body = mj_name2id(m.get(), mjOBJ_BODY, "cube");
  const Eigen::Vector3d c =
      Eigen::Map<const Eigen::Vector3d>(d->subtree_com + 3 * body) - Eigen::Map<const Eigen::Vector3d>(d->xpos + 3 * body);
  const Eigen::Matrix3d about_com = about_origin - 0.4 * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  EXPECT_LT((odd.objects[0].inertia - about_com).norm(), 1e-12);
}

TEST(Mjcf, SceneFile_MayReplaceStiffnessAndFrictionAndFilter) {
  const Scene scene = load_scene(data("odd_mjcf.yaml"));
  const auto model = Model::make(scene);
  ASSERT_EQ(model->n_a(), 5);
  EXPECT_EQ(model->stiffness()[model->joint_index("elbow")], 9);
  EXPECT_EQ(model->stiffness()[model->joint_index("lift")], 500);
  EXPECT_EQ(model->stiffness()[model->joint_index("finger_joint_0")], 800);
  EXPECT_EQ(model->objects()[0].name, "cube");
  EXPECT_TRUE(model->bodies()[static_cast<std::size_t>(body_index(*model, "arm_world"))].dofs.empty());

  std::set<std::pair<std::string, std::string>> pairs;
  for (const auto& pair : model->pairs()) {
    const auto& a = model->geometries()[static_cast<std::size_t>(pair.geometry_a)];
    const auto& b = model->geometries()[static_cast<std::size_t>(pair.geometry_b)];
    pairs.emplace(a.name, b.name);
    if (a.name == "cube/body" && b.name == "arm/finger/pad") {
      EXPECT_EQ(pair.max_distance, 0.01);
      EXPECT_DOUBLE_EQ(pair.friction, 2 * 0.5 * 0.9 / 1.4);
    }
  }
  EXPECT_TRUE(pairs.contains({"cube/body", "arm/finger/pad"}));
  EXPECT_TRUE(pairs.contains({"body_8/sphere_0", "arm_world/floor"}));
  EXPECT_FALSE(pairs.contains({"cube/body", "arm_world/floor"})) << "excluded";
  EXPECT_FALSE(pairs.contains({"arm/pedestal/box_0", "arm/finger/pad"})) << "excluded";
  EXPECT_FALSE(pairs.contains({"cube/body", "arm/flange/sphere_0"})) << "types and affinities 2 against 1";
  for (const auto& geometry : model->geometries()) EXPECT_EQ(geometry.name.find("cover"), std::string::npos) << "only seen";
}

TEST(Mjcf, WhatIsNotSupported_IsListedInOneMessage) {
  EXPECT_EQ(
      refused_mjcf(
          R"(<asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1"/></asset><worldbody><geom name="g" type="hfield" hfield="h"/><body name="b" mocap="true"><body><joint/><geom size="1"/></body></body></worldbody>)"),
      "mjcf: got 2 unsupported elements: body 'b' (a mocap body that carries joints); geom 'g' (a height field), expected "
      "hinge, "
      "slide, ball and free joints; sphere, capsule, box, cylinder, ellipsoid, plane and mesh geoms");
  EXPECT_NE(
      refused_mjcf(
          R"(<worldbody><body name="b"><freejoint/><geom size="1"/><body name="arm"><joint/><geom size="1"/></body></body></worldbody>)")
          .find("body 'arm' (a joint on a body with a free joint; fixed_base: true makes that stand still)"),
      std::string::npos);
}

TEST(Mjcf, WhatMeansNothingHere_IsNamedOnceAndPassedOver) {
  const auto file = write_mjcf(
      R"(<worldbody><geom name="a" size="1"/><body name="b"><joint name="j" stiffness="3"/><geom name="c" size="1"/></body></worldbody>
                                  <tendon><fixed name="t" stiffness="1"><joint joint="j" coef="1"/></fixed></tendon>
                                  <equality><weld name="w" body1="b"/></equality><contact><pair name="p" geom1="a" geom2="c"/></contact>
                                  <actuator><position joint="j" kp="4"/></actuator>)",
      "passed.xml");
  const auto model = make_model(file);
  ASSERT_EQ(model->notes().size(), 3u);  // the last one: no effort
  EXPECT_EQ(model->notes()[0],
            "arm: passed over: equality 'w' (a constraint beside joints and contacts); tendon 't' (a tendon with a spring); pair 'p' (a "
            "contact pair of bodies that are excluded or that a joint links)");
  EXPECT_EQ(model->notes()[1], "arm: springs add to the stiffness of motors, whose commands act against them, of joints: j");
  EXPECT_EQ(model->stiffness()[0], 7);
}

/// Fingers of metaworld are commanded 1 m beyond their travel of 40 mm, which presses with 384 N. A range that ends inside the limits is not read.
TEST(Mjcf, Commands_MayGoBeyondTheLimitsAsFarAsCtrlrange) {
  const auto model = make_robot(write_mjcf(
      R"(<worldbody><body name="b"><joint name="wide" type="slide" range="0 .04"/><geom size=".05"/>
           <body name="c"><joint name="narrow" type="slide" range="0 .04"/><geom size=".05"/>
             <body name="d"><joint name="geared" type="slide" range="-1 1"/><geom size=".05"/>
               <body name="e"><joint name="open" type="slide" range="-1 1"/><geom size=".05"/>
                 <body name="f"><joint name="follower" type="slide" range="-9 9"/><geom size=".05"/></body></body></body></body></body></worldbody>
         <equality><joint joint1="follower" joint2="open" polycoef="0.5 -2 0 0 0"/></equality>
         <actuator><position joint="wide" kp="400" ctrllimited="true" ctrlrange="-1 1"/><position joint="narrow" kp="400" ctrllimited="true" ctrlrange="0.01 0.03"/>
           <position joint="geared" kp="1" gear="-2" ctrllimited="true" ctrlrange="-1 4"/><position joint="follower" kp="1" ctrllimited="true" ctrlrange="-3 4"/>
           <position joint="open" kp="1" ctrllimited="true" ctrlrange="-1 3"/></actuator>)",
      "commands.xml"));
  EXPECT_TRUE(model->command_lower().isApprox(Eigen::Vector4d(-1, 0, -2, -1.75))) << model->command_lower().transpose();
  EXPECT_TRUE(model->command_upper().isApprox(Eigen::Vector4d(1, 0.04, 1, 3))) << model->command_upper().transpose();
  EXPECT_EQ(model->lower()[0], 0);
  EXPECT_EQ(model->upper()[0], 0.04);
}

/// The gripper of a Panda has such a servo: 255 opens it by 40 mm. MuJoCo's joint rests where the force of its servo and a load balance.
TEST(Mjcf, GeneralServo_HasTheStiffnessOfItsBias) {
  const auto file = write_mjcf(
      R"(<option gravity="0 0 0"/><worldbody><body name="b"><joint name="j" type="slide" range="0 .04" damping="20"/><geom size=".05"/></body></worldbody>
         <actuator><general name="m" joint="j" gainprm="0.01568627451" biastype="affine" biasprm="0 -100 -10" ctrlrange="0 255" ctrllimited="true"/></actuator>)",
      "general.xml");
  const auto model = make_robot(file);
  for (const std::string& note : model->notes()) EXPECT_EQ(note.find("ctrlrange"), std::string::npos) << note << ": 0 to 255 is 0 to 40 mm";
  EXPECT_EQ(joint_motors(*model)[0].damping, 10);

  const Owned<mjModel> m = load_mujoco(file);
  const Owned<mjData> d(mj_makeData(m.get()));
  const auto rest = [&](double load) {
    mj_resetData(m.get(), d.get());
    d->ctrl[0] = 127.5, d->qfrc_applied[0] = load;
    while (d->time < 10) mj_step(m.get(), d.get());
    return d->qpos[0];
  };
  EXPECT_NEAR(rest(0), 0.02, 1e-8);
  EXPECT_NEAR(model->stiffness()[0], 0.5 / (rest(0.5) - rest(0)), 1e-4);
}

/// The forearm of a Fetch has such a spring: it would sag by most of its range under its own weight. No motor is that soft.
TEST(Mjcf, SoftSpringWithoutActuator_IsNotTheStiffnessOfTheMotor) {
  const auto stiffness = [](const std::string& spring) {
    const auto file = write_mjcf(
        "<worldbody><body><joint name='a' axis='1 0 0' armature='1' " + spring + "/><geom size='.1' pos='0 .5 0'/></body></worldbody>",
        "soft.xml");
    const auto model = make_robot(file);
    const bool noted = std::ranges::any_of(model->notes(), [](const std::string& note) {
      return note == "arm: springs that are softer than this are left out [N·m/rad, N/m]: a 10";
    });
    EXPECT_EQ(noted, spring == "stiffness='10'") << fmt::format("{}", fmt::join(model->notes(), "\n"));
    return model->stiffness()[0];
  };
  const double chosen = stiffness("");
  EXPECT_GT(chosen, 100);
  EXPECT_EQ(stiffness("stiffness='10'"), chosen);
  EXPECT_EQ(stiffness("stiffness='3000'"), 3000);
}

/// Geoms of hands that meet others only where a pair says so, and geoms that do not collide but for their pair.
TEST(Mjcf, ContactPairs_MayTouchBesideWhatTypesAndAffinitiesSay) {
  const auto file = write_mjcf(
      R"(<worldbody><geom name="floor" type="plane" size="1 1 1" contype="0" conaffinity="0"/>
         <body><joint/><geom name="a" size=".1" contype="1" conaffinity="0"/></body><body pos=".21 0 0"><joint/><geom name="b" size=".1" contype="1" conaffinity="0"/></body>
         <body pos=".1 .19 0"><joint/><geom name="c" size=".1" contype="1" conaffinity="0"/></body><body pos="9 0 3"><freejoint/><geom name="d" size=".1" contype="0" conaffinity="0"/></body></worldbody>
         <contact><pair geom1="a" geom2="b"/><pair geom1="b" geom2="c"/><pair geom1="d" geom2="floor"/><pair name="easy" geom1="d" geom2="a" condim="3" friction="1 .5"/></contact>)",
      "pairs.xml");
  const auto model = make_model(file);
  std::set<std::string> pairs;
  const auto name = [&](int geometry) {
    return model->geometries()[static_cast<std::size_t>(geometry)].name.substr(
        model->geometries()[static_cast<std::size_t>(geometry)].name.rfind('/') + 1);
  };
  for (const Pair& pair : model->pairs()) pairs.insert(name(pair.geometry_a) + name(pair.geometry_b));
  EXPECT_EQ(pairs, (std::set<std::string>{"ab", "bc", "dfloor", "da"}));
  const auto notes = model->notes();
  EXPECT_TRUE(std::ranges::any_of(notes, [](const auto& n) {
    return n.find("friction along a second direction of contact pairs easy (that along the first one counts in all)") != std::string::npos;
  }));
  EXPECT_TRUE(std::ranges::none_of(notes, [](const auto& n) { return n.find("passed over") != std::string::npos; }));
}

TEST(Mjcf, JointsOfAnEquality_MoveTogether) {
  const auto file = write_mjcf(R"(<worldbody><body><joint name="x" type="slide" range="-1 1"/><geom size=".1"/></body>
                                  <body pos="3 0 0"><joint name="y" type="slide"/><geom size=".1"/></body></worldbody>
                                  <equality><joint joint1="y" joint2="x" polycoef=".1 -2 0 0 0"/></equality>)",
                               "coupled.xml");
  const auto model = make_model(file);
  ASSERT_EQ(model->n_a(), 1);
  ASSERT_EQ(model->followers().size(), 1u);
  EXPECT_EQ(model->followers()[0].ratio, -2);
  EXPECT_EQ(model->followers()[0].offset, 0.1);
}

TEST(Mjcf, EffortOfActuators_GivesJointsWithoutServoTheirStiffness) {
  const auto file = write_mjcf(
      R"(<worldbody><body><joint name="a" range="-90 90"/><geom size=".1"/></body><body pos="3 0 0"><joint name="b" range="-90 90"/><geom size=".1"/></body>
                                  <body pos="6 0 0"><joint name="c" range="-90 90" actuatorfrcrange="-2 2"/><geom size=".1"/></body></worldbody>
                                  <actuator><motor joint="a" ctrlrange="-3 3" gear="5"/><motor joint="b" forcerange="-4 4" gear="2"/></actuator>)",
      "motors.xml");
  const auto model = make_robot(file);
  const double angle = M_PI / 40;
  EXPECT_NEAR(model->stiffness()[0], 15 / angle, 1e-9);
  EXPECT_NEAR(model->stiffness()[1], 8 / angle, 1e-9);
  EXPECT_NEAR(model->stiffness()[2], 2 / angle, 1e-9);
}

TEST(Mjcf, WeightOfABodyThatGravcompHolds_IsNotThere) {
  const auto file =
      write_mjcf(R"(<worldbody><body name="o" gravcomp="0.75"><freejoint/><geom size=".1" mass="2"/></body></worldbody>)", "gravcomp.xml");
  const auto model = make_model(file);
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  calc_kinematics(*model, model->neutral(), work, kinematics);
  Eigen::VectorXd tau(6);
  calc_gravity(*model, kinematics, tau);
  EXPECT_NEAR(tau[2], -0.25 * 2 * 9.81, 1e-12);
}

TEST(Mjcf, MeshesOfLinks_LoseCornersAndThoseOfObjectsKeepThem) {
  const RobotContents model = read_mjcf(write_mjcf(
      R"(<asset><mesh name="round" builtin="sphere" params="4" scale=".1 .1 .1"/></asset><worldbody>
         <body name="link"><joint/><geom type="mesh" mesh="round"/></body><body name="o"><freejoint/><geom type="mesh" mesh="round"/></body></worldbody>)",
      "round.xml"));
  const auto corners = [](const Shape& shape) { return std::get<Mesh>(shape).mesh->vertices; };
  const auto of_link = corners(model.robot.links[1].collisions.at(0).shape),
             of_object = corners(model.objects.at(0).geometries.at(0).shape);
  EXPECT_LT(of_link.cols(), of_object.cols() / 2);
  for (const auto& corner : of_link.colwise())
    EXPECT_LT((of_object.colwise() - corner).colwise().norm().minCoeff(), 1e-12) << "is one of the file";
  const auto& notes = model.robot.notes;
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.starts_with("corners of the hulls") && note.ends_with(": round");
  })) << fmt::format("{}", fmt::join(notes, "; "));
}

TEST(Mjcf, FilesThatMujocoRefuses_AreNamedWithItsReason) {
  EXPECT_EQ(message_of_file("nowhere.xml"), "nowhere.xml: mjcf: got a file that does not exist, expected an MJCF file");
  EXPECT_NE(refused_mjcf("<worldbody><bodi/></worldbody>").find("bodi"), std::string::npos)
      << refused_mjcf("<worldbody><bodi/></worldbody>");
  EXPECT_NE(refused_mjcf(R"(<worldbody><body><joint/></body></worldbody>)").find("mass and inertia"), std::string::npos);
  EXPECT_NE(refused_mjcf(R"(<worldbody><geom type="mesh" mesh="no"/></worldbody>)").find("no"), std::string::npos);
  EXPECT_FALSE(fs::exists("MUJOCO_LOG.TXT"));
}

}  // namespace
}  // namespace stiction::world::test
