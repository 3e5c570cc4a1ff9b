// Joints of an MJCF that follow others, checked against the constraints that MuJoCo makes of the file.
#include "stiction/world/mjcf_couplings.hpp"

#include <fmt/format.h>

#include <cmath>

#include "stiction/core/random.hpp"
#include "stiction/world/nearest_line.hpp"
#include "stiction/world/read.hpp"
#include "world/mjcf_oracle.hpp"

namespace stiction::world::test {
namespace {

namespace fs = std::filesystem;

/// A chain of links on hinges of the given names, each with a range of ±1.
std::string chain(const std::vector<std::string>& joints, const std::string& attributes = "range='-1 1'") {
  std::string out, end;
  for (const std::string& joint : joints) {
    out += fmt::format("<body pos='.3 0 0'><joint name='{}' {}/><geom size='.05'/>", joint, attributes);
    end += "</body>";
  }
  return out + end;
}

/// A file as MuJoCo compiles it, with what is made of its constraints.
struct Coupled {
  explicit Coupled(const std::string& content, const RobotSpec& robot = {})
      : file(write_mjcf("<compiler angle='radian'/>" + content, "coupled.xml")),
        m(load_mujoco(file)),
        roles(*m, robot, file),
        couplings(MjcfView(m.get(), roles, file)) {}

  const MjcfCoupling& of(const char* joint) const { return couplings.of(mj_name2id(m.get(), mjOBJ_JOINT, joint)); }
  const char* leader(const char* joint) const {
    const int leader = of(joint).leader;
    return leader < 0 ? "" : mj_id2name(m.get(), mjOBJ_JOINT, leader);
  }

  fs::path file;
  Owned<mjModel> m;
  MjcfRoles roles;
  MjcfCouplings couplings;
};

const RobotJoint& joint_of(const RobotTree& tree, const std::string& name) {
  return *std::find_if(tree.joints.begin(), tree.joints.end(), [&](const RobotJoint& joint) { return joint.name == name; });
}

/// Largest violation of an equality that MuJoCo finds where joints that lead are anywhere and the others follow them.
double worst_violation(const Coupled& coupled) {
  const mjModel* m = coupled.m.get();
  const Owned<mjData> d(mj_makeData(m));
  core::Random random(11, 1);
  double worst = 0;
  int equalities = 0;
  for (int sample = 0; sample < 20; ++sample) {
    for (int j = 0; j < m->njnt; ++j) d->qpos[m->jnt_qposadr[j]] = random.normal();
    for (int j = 0; j < m->njnt; ++j) {
      const MjcfCoupling& line = coupled.couplings.of(j);
      if (line.leader == j) continue;
      d->qpos[m->jnt_qposadr[j]] = line.offset + (line.leader < 0 ? 0 : line.ratio * d->qpos[m->jnt_qposadr[line.leader]]);
    }
    mj_fwdPosition(m, d.get());
    for (int row = 0; row < d->nefc; ++row) {
      if (d->efc_type[row] != mjCNSTR_EQUALITY) continue;
      ++equalities;
      worst = std::max(worst, std::abs(d->efc_pos[row]));
    }
  }
  EXPECT_GE(equalities, 20) << "MuJoCo has no equality: the test would say nothing";
  return worst;
}

TEST(MjcfCouplings, TendonEqualities_HoldInMujocoEverywhere) {
  // The second finger hangs on a tree of its own, and its tendons stand before those that lead to a joint with an actuator.
  const Coupled coupled("<worldbody><body>" + chain({"a", "b", "c"}, "range='-2 2' ref='.3'") + "</body><body>" + chain({"d", "e"}) +
                        R"(</body></worldbody><tendon><fixed name="bc"><joint joint="b" coef=".5"/><joint joint="c" coef="-1"/></fixed>
    <fixed name="ab"><joint joint="a" coef="2"/><joint joint="b" coef=".5"/></fixed><fixed name="d"><joint joint="d" coef="1.5"/></fixed>
    <fixed name="a"><joint joint="a" coef="-3"/></fixed><fixed name="e"><joint joint="e" coef="4"/></fixed></tendon>
    <equality><tendon tendon1="bc"/><tendon tendon1="d" tendon2="a" polycoef=".1 .7 0 0 0"/><tendon tendon1="ab"/><tendon tendon1="e" polycoef=".2 0 0 0 0"/></equality>
    <actuator><position joint="a" kp="20"/></actuator>)");
  for (const char* follower : {"b", "c", "d"}) EXPECT_STREQ(coupled.leader(follower), "a") << follower;
  EXPECT_STREQ(coupled.leader("e"), "") << "it stands still";
  EXPECT_DOUBLE_EQ(coupled.of("e").offset, 0.05);
  EXPECT_DOUBLE_EQ(coupled.of("b").ratio, -4);
  EXPECT_LT(worst_violation(coupled), 1e-12);
  EXPECT_TRUE(MjcfView(coupled.m.get(), coupled.roles, coupled.file).list_passed_over(coupled.couplings.meaning()).empty());
}

/// Of a scene in one file, a tree without an actuator is the robot's where a tendon ties it to one with an actuator.
TEST(MjcfCouplings, TreesThatATendonTiesToTheRobot_AreTheRobots) {
  write_mjcf("<compiler angle='radian'/><worldbody>" + chain({"a"}) + chain({"b"}) + chain({"c"}) +
                 R"(</worldbody><tendon><fixed name="t"><joint joint="a" coef="1"/><joint joint="b" coef="2"/></fixed></tendon>
                    <equality><tendon tendon1="t"/></equality><actuator><position joint="a"/></actuator>)",
             "tied.xml");
  const Scene scene = parse_scene("file: tied.xml", stiction::test::folder_of_the_process());
  EXPECT_EQ(scene.objects.size(), 1u) << "the one on c";
  EXPECT_EQ(scene.robots[0].contents->robot.movable_joints(), (std::vector<std::string>{"a"}));
}

/// A gripper with an equality between its fingers and an actuator on a tendon of both, as the hand of a Panda has it.
TEST(MjcfCouplings, EqualityAndActuatedTendonOfTheSameJoints_AreNoCircle) {
  const std::string fingers =
      "<worldbody><body>" + chain({"l"}, "type='slide' range='0 .04'") + chain({"r"}, "type='slide' range='0 .04'") +
      R"(</body></worldbody><tendon><fixed name="split"><joint joint="l" coef=".5"/><joint joint="r" coef=".5"/></fixed></tendon>
                              <equality><joint joint1="l" joint2="r"/></equality>)";
  const Coupled coupled(fingers + R"(<actuator><position tendon="split" kp="100" forcerange="-70 70"/></actuator>)");
  EXPECT_LT(worst_violation(coupled), 1e-12);
  const RobotContents contents = read_mjcf(coupled.file);
  ASSERT_EQ(contents.robot.movable_joints(), (std::vector<std::string>{"r"}));
  EXPECT_DOUBLE_EQ(*joint_of(contents.robot, "r").stiffness, 100) << "the tendon moves by 0.5 + 0.5 per motion of both";
  EXPECT_DOUBLE_EQ(*joint_of(contents.robot, "r").effort, 70);
}

TEST(MjcfCouplings, JointWithAnActuator_LeadsAndBearsTheMotorsOfWhatFollows) {
  const std::string joints =
      "<worldbody>" + chain({"a", "b"}) + "</worldbody><equality><joint joint1='a' joint2='b' polycoef='0 -2 0 0 0'/></equality>";
  const Coupled one(joints + "<actuator><position joint='a' kp='10'/></actuator>");
  EXPECT_STREQ(one.leader("b"), "a") << "although a stands first";
  EXPECT_DOUBLE_EQ(one.of("b").ratio, -0.5);
  const Coupled both(joints +
                     "<actuator><position joint='a' kp='10' forcerange='-3 3'/><position joint='b' kp='5' forcerange='-1 1'/></actuator>");
  EXPECT_STREQ(both.leader("a"), "b");
  const RobotTree tree = read_mjcf(both.file).robot;
  EXPECT_DOUBLE_EQ(*joint_of(tree, "b").stiffness, 5 + 10 * 4) << "at the same energy";
  EXPECT_DOUBLE_EQ(*joint_of(tree, "b").effort, 1 + 3 * 2) << "at the same power";
}

TEST(MjcfCouplings, AsManyTendonsAsJoints_LeaveEachItsMotor) {
  const std::string joints = "<worldbody>" + chain({"a", "b"}) + "</worldbody>";
  const auto drive = [&](double a, double b, double c, double d) {
    return Coupled(
        joints +
        fmt::format("<tendon><fixed name='s'><joint joint='a' coef='{}'/><joint joint='b' coef='{}'/></fixed><fixed name='t'><joint "
                    "joint='a' coef='{}'/><joint joint='b' coef='{}'/></fixed></tendon>"
                    "<actuator><position tendon='s' kp='10'/><position tendon='t' kp='10'/></actuator>",
                    a, b, c, d));
  };
  const Coupled differential = drive(0.5, 0.5, 0.5, -0.5), straight = drive(1, 0, 0, 2), same = drive(1, 2, 2, 4);
  EXPECT_TRUE(differential.couplings.list().empty());
  EXPECT_TRUE(straight.couplings.list().empty());
  EXPECT_STREQ(same.leader("b"), "a") << "one pull on both";
  const RobotTree tree = read_mjcf(drive(0.5, 0.5, 0.5, -0.5).file).robot;
  EXPECT_DOUBLE_EQ(*joint_of(tree, "a").stiffness, 2 * 10 * 0.25);
  EXPECT_DOUBLE_EQ(*joint_of(tree, "b").stiffness, 2 * 10 * 0.25);
}

/// A finger whose outermost joint a tendon couples to the next, as in a Shadow hand.
TEST(MjcfCouplings, LimitsOfTendons_AreJointsThatFollowOrLimitsOfJoints) {
  const auto limited = [](const std::string& coupling) {
    return Coupled("<worldbody>" + chain({"middle", "tip"}, "range='0 1.5'") + "</worldbody><tendon><fixed name='c' range='" + coupling +
                   R"('><joint joint="tip" coef=".007"/><joint joint="middle" coef="-.008"/></fixed>
    <fixed name="never" range="-.001 .03"><joint joint="tip" coef=".007"/><joint joint="middle" coef=".008"/></fixed>
    <fixed name="m" range="0 .006"><joint joint="middle" coef=".008"/></fixed></tendon><actuator><position joint="middle"/></actuator>)");
  };
  const Coupled coupled = limited("-.001 .001");
  EXPECT_STREQ(coupled.leader("tip"), "middle");
  EXPECT_DOUBLE_EQ(coupled.of("tip").ratio, 8.0 / 7);
  EXPECT_DOUBLE_EQ(coupled.of("tip").offset, 0);
  EXPECT_DOUBLE_EQ(coupled.of("tip").room, 1.0 / 7);
  ASSERT_EQ(coupled.couplings.notes().size(), 1u);
  EXPECT_NE(coupled.couplings.notes()[0].find("at most [rad, m]: tip 0.143"), std::string::npos) << coupled.couplings.notes()[0];
  const auto limits = coupled.couplings.limits(mj_name2id(coupled.m.get(), mjOBJ_JOINT, "middle"));
  ASSERT_TRUE(limits);
  EXPECT_DOUBLE_EQ(limits->second, 0.75);
  const RobotContents contents = read_mjcf(coupled.file);
  EXPECT_DOUBLE_EQ(joint_of(contents.robot, "middle").upper, 0.75);
  for (const std::string& note : contents.robot.notes) EXPECT_EQ(note.find("passed over"), std::string::npos) << note;
  const Coupled loose = limited("-.005 .007");
  EXPECT_TRUE(loose.couplings.list().empty());
  EXPECT_EQ(MjcfView(loose.m.get(), loose.roles, loose.file).list_passed_over(loose.couplings.meaning()),
            (std::vector<std::string>{"tendon 'c' (a tendon with a limit)"}));
}

TEST(MjcfCouplings, WhatNoJointCanFollow_IsPassedOver) {
  const Coupled coupled(
      "<worldbody>" + chain({"a", "b", "c"}) +
      R"(</worldbody><tendon><fixed name="three"><joint joint="a" coef="1"/><joint joint="b" coef="1"/><joint joint="c" coef="1"/></fixed>
    <fixed name="c"><joint joint="c" coef="1"/></fixed><fixed name="a" stiffness="1"><joint joint="a" coef="1"/></fixed><fixed name="b" stiffness="2"><joint joint="b" coef="1"/></fixed></tendon>
    <equality><tendon name="sum" tendon1="three"/><tendon name="curve" tendon1="a" tendon2="c" polycoef="0 1 1 0 0"/>
    <tendon name="fixes" tendon1="b"/><tendon name="contradicts" tendon1="b" polycoef=".5 0 0 0 0"/></equality>)");
  const auto passed = MjcfView(coupled.m.get(), coupled.roles, coupled.file).list_passed_over(coupled.couplings.meaning());
  EXPECT_EQ(passed, (std::vector<std::string>{"equality 'curve' (a constraint beside joints and contacts)",
                                              "equality 'contradicts' (a constraint beside joints and contacts)",
                                              "tendon 'a' (a tendon with a spring)"}))
      << "with b fixed, the sum of three ties c to a; and the spring on b cannot move";
  EXPECT_STREQ(coupled.leader("c"), "a");
}

TEST(NearestLine, OfAParabola_IsTheChordThatIsLiftedHalfWay) {
  const auto square = [](double x) { return x * x; };
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const NearestLine whole = nearest_line(square, {0, 1}, {-kAll, kAll});
  EXPECT_NEAR(whole.slope, 1, 1e-12);
  EXPECT_NEAR(whole.offset, -1.0 / 8, 1e-12);
  EXPECT_NEAR(whole.error, 1.0 / 8, 1e-12);
  const NearestLine part = nearest_line(square, {0, 1}, {0, 0.25});
  EXPECT_NEAR(part.slope, 0.5, 1e-12) << "beyond x = 1/2 the follower is at its limit";
  EXPECT_NEAR(part.error, 1.0 / 32, 1e-12);
  const NearestLine line = nearest_line([](double x) { return 3 * x - 2; }, {-2, 5}, {-kAll, kAll});
  EXPECT_NEAR(line.slope, 3, 1e-12);
  EXPECT_NEAR(line.error, 0, 1e-12);
}

/// Of a polynomial of the fourth degree no other line is nearer at all its points, and its error is what is said.
TEST(MjcfCouplings, Polynomial_FollowsTheNearestLineOverTheRangesOfBoth) {
  const Coupled coupled("<worldbody>" + chain({"knee"}, "range='0 2'") + chain({"shift"}, "range='-1 .2' ref='.1'") +
                        R"(</worldbody><equality><joint joint1="shift" joint2="knee" polycoef="-.05 .1 .2 -.3 .05"/></equality>)");
  const auto value = [](double x) { return 0.1 - 0.05 + x * (0.1 + x * (0.2 + x * (-0.3 + x * 0.05))); };
  const MjcfCoupling& line = coupled.of("shift");
  const auto worst = [&](double ratio, double offset) {
    double out = 0;
    for (int k = 0; k <= 1000; ++k) {
      const double x = 2.0 * k / 1000;
      if (value(x) >= -1 && value(x) <= 0.2) out = std::max(out, std::abs(value(x) - ratio * x - offset));
    }
    return out;
  };
  const double error = worst(line.ratio, line.offset);
  for (const double d : {-0.01, 0.01}) {
    EXPECT_GT(worst(line.ratio + d, line.offset), error);
    EXPECT_GT(worst(line.ratio + d, line.offset - d), error);
    EXPECT_GT(worst(line.ratio, line.offset + d), error);
  }
  const std::string note = coupled.couplings.notes()[0];
  const double said = std::stod(note.substr(note.find("shift ") + 6));
  constexpr double kSpacing = 2.0 / 64, kMostCurvature = 2 * 0.2 + 6 * 0.3 * 2, kDigits = 5e-4;
  EXPECT_NEAR(said, error, kSpacing * kSpacing / 8 * kMostCurvature + kDigits) << note;
}

}  // namespace
}  // namespace stiction::world::test
