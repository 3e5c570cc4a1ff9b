// Efforts of motors: from URDF and MJCF, over them from the scene.
#include <fstream>
#include <limits>

#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"
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

/// forcerange goes through the gear; what the joint itself bears goes before it; a motor's force is its control range.
TEST_F(Effort, OfMjcf_IsThatOfActuatorsOrOfTheJoint) {
  (void)write("arm.xml", R"(<mujoco model="arm"><compiler angle="radian"/><worldbody>
  <body name="l1"><joint name="j1" axis="1 0 0"/><geom size="0.1"/>
  <body name="l2" pos="0 0 1"><joint name="j2" axis="1 0 0" actuatorfrcrange="-3 2"/><geom size="0.1"/>
  <body name="l3" pos="0 0 1"><joint name="j3" axis="1 0 0"/><geom size="0.1"/>
  <body name="l4" pos="0 0 1"><joint name="j4" axis="1 0 0"/><geom size="0.1"/></body></body></body></body></worldbody>
  <actuator><position joint="j1" kp="10" gear="2" forcerange="-5 5"/><position joint="j2" kp="10" forcerange="-9 9"/>
  <motor joint="j3" gear="3" ctrlrange="-1 1"/><position joint="j4" kp="10"/></actuator></mujoco>)");
  const auto model = load("", "mjcf: arm.xml");
  EXPECT_EQ(model->effort(), Eigen::Vector4d(10, 3, 3, kInfinity));
  EXPECT_EQ(load("    effort: {j4: 2}\n", "mjcf: arm.xml")->effort()[3], 2);
}

/// Of a motor the smaller of both ranges counts: here its commands ask for less, and there its force is limited first.
TEST_F(Effort, OfAMotorWithBothRanges_IsTheSmallerOne) {
  (void)write("arm.xml", R"(<mujoco model="arm"><compiler angle="radian"/><worldbody>
  <body name="l1"><joint name="j1" axis="1 0 0"/><geom size="0.1"/><body name="l2" pos="0 0 1"><joint name="j2" axis="1 0 0"/><geom size="0.1"/></body></body>
  </worldbody><actuator><motor joint="j1" gear="150" ctrlrange="-1 1" forcerange="-87 87"/>
  <motor joint="j2" gear="2" ctrlrange="-9 9" forcerange="-4 3"/></actuator></mujoco>)");
  EXPECT_EQ(load("", "mjcf: arm.xml")->effort(), Eigen::Vector2d(150, 8));
}

}  // namespace
}  // namespace stiction::world::test
