// Efforts of motors: from URDF and MJCF, over them from the scene.
#include <fmt/format.h>

#include <fstream>
#include <limits>

#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"
#include "world/mjcf_oracle.hpp"
#include "world/robot_files.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world::test {
namespace {

using stiction::test::message_of;

class Effort : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  /// Three joints with the attributes of their limits.
  void write_arm(const std::string& a, const std::string& b, const std::string& c) const {
    std::string text = "<robot name='arm'><link name='l0'/>\n";
    int i = 0;
    for (const std::string& limit : {a, b, c}) {
      const std::string n = std::to_string(++i);
      text += "<link name='l" + n + "'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>\n<joint name='j" + n +
              "' type='revolute'><parent link='l" + std::to_string(i - 1) + "'/><child link='l" + n +
              "'/><origin xyz='0 0 1'/><axis xyz='1 0 0'/>" + "<limit lower='-1' upper='1' velocity='1' " + limit + "/></joint>\n";
    }
    (void)write("arm.urdf", text + "</robot>");
  }

  std::shared_ptr<const Model> load(const std::string& keys, const std::string& robot = "urdf: arm.urdf") const {
    return Model::make(load_scene(write("scene.yaml", "robots:\n  - name: arm\n    " + robot + "\n    stiffness: 1\n" + keys)));
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& folder_ = temporary_.path();
};

TEST_F(Effort, OfUrdf_IsThatOfTheModel) {
  write_arm("effort='3'", "effort='4.5'", "effort='inf'");
  const auto model = load("");
  EXPECT_EQ(model->effort(), Eigen::Vector3d(3, 4.5, kInfinity));
  EXPECT_EQ(model->dofs()[1].effort, 4.5);
}

TEST_F(Effort, OfScene_GoesBeforeTheFile) {
  write_arm("effort='3'", "effort='4'", "effort='5'");
  EXPECT_EQ(load("    effort: 2\n")->effort(), Eigen::Vector3d(2, 2, 2));
  EXPECT_EQ(load("    effort: ~\n")->effort(), Eigen::Vector3d(kInfinity, kInfinity, kInfinity));
  EXPECT_EQ(load("    effort: [1, ~, 0.5]\n")->effort(), Eigen::Vector3d(1, kInfinity, 0.5));
  EXPECT_EQ(load("    effort: {j2: ~, j3: 7}\n")->effort(), Eigen::Vector3d(3, kInfinity, 7));
}

TEST_F(Effort, MissingOr0InTheFile_NoLimitAndOneNote) {
  write_arm("effort='3'", "effort='0'", "");
  const auto model = load("");
  EXPECT_EQ(model->effort(), Eigen::Vector3d(3, kInfinity, kInfinity));
  ASSERT_EQ(model->notes().size(), 1u);
  EXPECT_EQ(model->notes()[0], "arm: motors whose effort nobody states (or states as 0), and which may bear anything, of joints: j2, j3");
  EXPECT_TRUE(load("    effort: {j2: ~, j3: 1}\n")->notes().empty()) << "the scene states them";
}

TEST_F(Effort, NotPositive_NamesFileLineAndField) {
  write_arm("effort='3'", "effort='-4'", "effort='5'");
  const std::string of_file = message_of([&] { (void)load(""); });
  EXPECT_NE(of_file.find("arm.urdf:5: joint 'j2' effort: got -4, expected a number > 0, or 0 where it is not known"), std::string::npos)
      << of_file;
  write_arm("effort='3'", "effort='4'", "effort='5'");
  const auto says = [&](const std::string& keys, const std::string& expected) {
    const std::string message = message_of([&] { (void)load(keys); });
    EXPECT_NE(message.find(expected), std::string::npos) << message;
  };
  says("    effort: 0\n", "scene.yaml:5: robots[0].effort: got 0, expected a number > 0");
  says("    effort: {j1: -2}\n", "scene.yaml:5: robots[0].effort.j1: got -2, expected a number > 0");
  says("    effort: [1, 2]\n", "scene.yaml:5: robots[0].effort: got");
  says("    effort: {j4: 1}\n", "scene.yaml:5: robots[0].effort.j4: got unknown joint 'j4'");
}

TEST_F(Effort, OfSceneMadeInCode_IsCheckedToo) {
  write_arm("effort='3'", "effort='4'", "effort='5'");
  Scene scene;
  RobotSpec robot;
  robot.name = "arm";
  robot.urdf = folder_ / "arm.urdf";
  robot.stiffness = {{"j1", 1}, {"j2", 1}, {"j3", 1}};
  robot.effort = {{"j2", std::numeric_limits<double>::quiet_NaN()}};
  scene.robots.push_back(robot);
  EXPECT_EQ(message_of([&] { (void)Model::make(scene); }), "robots[0]: effort.j2: got nan, expected a number > 0, or infinity for none");
}

/// forcerange goes through the gear; the joint itself limits the force as well; a motor's force is its control range.
TEST_F(Effort, OfMjcf_IsThatOfActuatorsAndOfTheJoint) {
  (void)write("arm.xml", R"(<mujoco model="arm"><compiler angle="radian"/><worldbody>
  <body name="l1"><joint name="j1" axis="1 0 0"/><geom size="0.1"/>
  <body name="l2" pos="0 0 1"><joint name="j2" axis="1 0 0" actuatorfrcrange="-3 2"/><geom size="0.1"/>
  <body name="l3" pos="0 0 1"><joint name="j3" axis="1 0 0"/><geom size="0.1"/>
  <body name="l4" pos="0 0 1"><joint name="j4" axis="1 0 0"/><geom size="0.1"/></body></body></body></body></worldbody>
  <actuator><position joint="j1" kp="10" gear="2" forcerange="-5 5"/><position joint="j2" kp="10" forcerange="-9 9"/>
  <motor joint="j3" gear="3" ctrlrange="-1 1"/><position joint="j4" kp="10"/></actuator></mujoco>)");
  const auto model = load("", "mjcf: arm.xml");
  EXPECT_EQ(model->effort(), Eigen::Vector4d(10, 2, 3, kInfinity));
  EXPECT_EQ(load("    effort: {j4: 2}\n", "mjcf: arm.xml")->effort()[3], 2);
}

/// Of a motor the smaller of both ranges counts: here its commands ask for less, and there its force is limited first.
TEST_F(Effort, OfAMotorWithBothRanges_IsTheSmallerOne) {
  (void)write("arm.xml", R"(<mujoco model="arm"><compiler angle="radian"/><worldbody>
  <body name="l1"><joint name="j1" axis="1 0 0"/><geom size="0.1"/><body name="l2" pos="0 0 1"><joint name="j2" axis="1 0 0"/><geom size="0.1"/></body></body>
  </worldbody><actuator><motor joint="j1" gear="150" ctrlrange="-1 1" forcerange="-87 87"/>
  <motor joint="j2" gear="2" ctrlrange="-9 9" forcerange="-4 3"/></actuator></mujoco>)");
  EXPECT_EQ(load("", "mjcf: arm.xml")->effort(), Eigen::Vector2d(150, 6));
}

// ---- efforts of MJCF, against the forces of MuJoCo

/// A chain of two joints with these attributes of the first, and what comes after the bodies.
std::string two_joints(const std::string& attributes, const std::string& more, const std::string& joint = "axis='0 0 1' range='-1 1'") {
  return fmt::format(
      "<compiler angle='radian'/><worldbody><body><joint name='j1' {} {}/><geom type='capsule' fromto='.05 0 0 .3 0 0' size='.02'/>"
      "<body pos='.3 0 0'><joint name='j2' axis='0 0 1' range='-1 1'/><geom type='capsule' fromto='.05 0 0 .3 0 0' size='.02'/></body>"
      "</body></worldbody>{}",
      joint, attributes, more);
}

/// Smallest and largest force of all actuators along each dof, over the ends of all commands. Commands without limits end at ±1e6.
std::pair<Eigen::VectorXd, Eigen::VectorXd> forces_of_mujoco(const std::filesystem::path& file) {
  const Owned<mjModel> m = load_mujoco(file);
  const Owned<mjData> d(mj_makeData(m.get()));
  Eigen::VectorXd least = Eigen::VectorXd::Zero(m->nv), most = least;
  for (int corner = 0; corner < 1 << m->nu; ++corner) {
    for (int i = 0; i < m->nu; ++i) d->ctrl[i] = (corner >> i & 1) != 0 ? 1e6 : -1e6;
    mj_forward(m.get(), d.get());
    const Eigen::Map<const Eigen::VectorXd> force(d->qfrc_actuator, m->nv);
    least = least.cwiseMin(force), most = most.cwiseMax(force);
  }
  return {least, most};
}

/// The weaker of both directions, or the only one; infinite where MuJoCo follows a command of 1e6.
double expected_effort(double least, double most) {
  const double weaker = std::min(-least, most), effort = weaker > 0 ? weaker : std::max(-least, most);
  return effort > 1e5 ? kInfinity : effort;
}

TEST(EffortOfMjcf, OfActuatorsOnOneJoint_IsTheirForceInMujoco) {
  const struct {
    const char *joint, *actuators;
  } kCases[] = {
      {"actuatorfrcrange='-100 100'", "<position joint='j1' kp='1000' forcerange='-5 5'/>"},
      {"actuatorfrcrange='-3 4'", "<position joint='j1' kp='1000' forcerange='-5 5'/>"},
      {"", "<motor joint='j1' gear='10' ctrlrange='0 1'/>"},
      {"", "<motor joint='j1' gear='10' ctrlrange='0 1'/><motor joint='j1' gear='-10' ctrlrange='0 1'/>"},
      {"", "<motor joint='j1' gear='10' ctrlrange='0 1'/><motor joint='j1' gear='-4' ctrlrange='0 2'/>"},
      {"", "<position joint='j1' kp='1000' forcerange='0 5'/>"},
      {"", "<position joint='j1' kp='1000' forcerange='-2 5'/>"},
      {"", "<position joint='j1' kp='1000'/><motor joint='j1' ctrlrange='-5 5'/>"},
      {"actuatorfrcrange='-7 7'", "<position joint='j1' kp='1000'/><motor joint='j1' ctrlrange='-5 5'/>"},
      {"", "<motor joint='j1' ctrlrange='-5 5'/><damper joint='j1' kv='3' ctrlrange='0 1'/>"},
      {"", "<velocity joint='j1' kv='3' ctrlrange='-2 2'/><motor joint='j1' gear='2' ctrlrange='-9 9' forcerange='-4 4'/>"},
      {"", "<general joint='j1' gainprm='3' biastype='affine' biasprm='1 0 0' ctrlrange='-2 2'/>"},
  };
  for (const auto& [joint, actuators] : kCases) {
    const auto file = write_mjcf(two_joints(joint, fmt::format("<actuator>{}<motor joint='j2' ctrlrange='-1 1'/></actuator>", actuators)));
    const auto [least, most] = forces_of_mujoco(file);
    EXPECT_DOUBLE_EQ(make_model(file)->effort()[0], expected_effort(least[0], most[0])) << joint << " " << actuators;
  }
}

/// Two joints on one tendon move together; the force on the leader is that on both, at the same power.
TEST(EffortOfMjcf, OfActuatorsOnATendon_IsTheirForceInMujoco) {
  const char* const kServo = "<position tendon='t' kp='1000' forcerange='-50 50' gear='2'/>";
  const struct {
    const char *joint, *tendon, *actuators;
  } kCases[] = {
      {"", "", kServo},
      {"", "actuatorfrcrange='-2 2'", kServo},
      {"", "actuatorfrcrange='-2 3'", kServo},
      {"actuatorfrcrange='-4 4'", "", kServo},
      {"actuatorfrcrange='-4 4'", "actuatorfrcrange='-10 10'", kServo},
      {"", "actuatorfrcrange='-2 2'", "<motor tendon='t' gear='5' ctrlrange='0 1'/><motor tendon='t' gear='-5' ctrlrange='0 1'/>"},
  };
  for (const auto& [joint, tendon, actuators] : kCases) {
    const auto file = write_mjcf(two_joints(joint, fmt::format("<tendon><fixed name='t' {}><joint joint='j1' coef='1'/><joint joint='j2' "
                                                               "coef='-.5'/></fixed></tendon><actuator>{}</actuator>",
                                                               tendon, actuators)));
    const auto model = make_model(file);
    ASSERT_EQ(model->followers().size(), 1u);
    const auto [least, most] = forces_of_mujoco(file);
    const double ratio = model->followers()[0].ratio;
    ASSERT_LT(ratio, 0);
    EXPECT_DOUBLE_EQ(model->effort()[0], expected_effort(least[0] + ratio * most[1], most[0] + ratio * least[1]))
        << joint << " " << tendon << " " << actuators;
  }
}

TEST(EffortOfMjcf, OfActuatorsOnABall_IsThatOfItsAxes) {
  const auto file = write_mjcf(two_joints("", R"(<actuator><motor joint="j1" gear="1 0 0" ctrlrange="-2 2"/>
      <position joint="j1" gear="0 -2 0" kp="5" forcerange="-3 3"/><motor joint="j2" ctrlrange="-1 1"/></actuator>)",
                                          "type='ball'"));
  const auto model = make_robot(file);
  const auto [least, most] = forces_of_mujoco(file);
  const auto of = [&](const char* name) { return model->joint_index(name); };
  EXPECT_EQ(model->effort()[of("j1_x")], most[0]);
  EXPECT_EQ(model->effort()[of("j1_y")], most[1]);
  EXPECT_EQ(model->stiffness()[of("j1_y")], 20);
  EXPECT_EQ(model->effort()[of("j1_z")], kInfinity);
  EXPECT_TRUE(has_note(*model, "motors whose effort nobody states (or states as 0), and which may bear anything, of joints: j1_z"));
  const auto skew = make_robot(write_mjcf(
      two_joints("", "<actuator><motor name='both' joint='j1' gear='1 2 0' ctrlrange='-2 2'/></actuator>", "type='ball'"), "skew.xml"));
  EXPECT_EQ(skew->effort()[of("j1_y")], 4);
  EXPECT_TRUE(has_note(*skew, "actuators that turn a ball joint about several of its axes act on each hinge alone: actuator 'both'"));
}

TEST(EffortOfMjcf, DeviationsFromTheFile_AreNotedByJoint) {
  const auto notes = [](const std::string& actuators) { return make_robot(write_mjcf(two_joints("", actuators))); };
  const char* const kEqual = "efforts are the same in both directions, so ";
  const auto one_sided = notes("<actuator><motor joint='j1' gear='10' ctrlrange='0 1'/></actuator>");
  EXPECT_TRUE(
      has_note(*one_sided, fmt::format("{}motors that act in one direction act in both with the same force, of joints: j1", kEqual)));
  const auto uneven = notes("<actuator><position joint='j1' forcerange='-2 5'/></actuator>");
  EXPECT_TRUE(has_note(*uneven, fmt::format("{}the weaker direction of motors counts for both, of joints: j1", kEqual)));
  const auto pair =
      notes("<actuator><motor joint='j1' gear='10' ctrlrange='0 1'/><motor joint='j1' gear='-10' ctrlrange='0 1'/></actuator>");
  EXPECT_FALSE(has_note(*pair, kEqual));
  const auto both = notes(R"(<tendon><fixed name="t"><joint joint="j1" coef="1"/><joint joint="j2" coef="1"/></fixed></tendon>
      <actuator><position joint="j1" kp="2" forcerange="-1 1"/><position tendon="t" kp="5" forcerange="-3 3"/></actuator>)");
  EXPECT_EQ(both->effort(), Eigen::Vector2d(1, 3));
  EXPECT_TRUE(has_note(*both, "actuators on tendons do not act on joints that have motors of their own: tendon 't' on j1"));
}

}  // namespace
}  // namespace stiction::world::test
