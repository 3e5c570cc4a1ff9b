// Joints in the section `start` of a task: as a list or by name, with or without those that follow others.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "stiction/tasks/task.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;
using stiction::test::message_of;

/// Two grippers whose second finger follows the first: right = −2 left + 0.01.
class StartSection : public testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(dir_ / "gripper.urdf") << R"(<robot name="gripper">
  <link name="palm"/>
  <link name="a"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="b"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="wrist"/>
  <joint name="left" type="prismatic"><parent link="palm"/><child link="a"/><axis xyz="0 1 0"/><origin xyz="0 0.05 0"/><limit lower="-0.02" upper="0.02" effort="9"/></joint>
  <joint name="right" type="prismatic"><parent link="palm"/><child link="b"/><axis xyz="0 1 0"/><origin xyz="0 -0.05 0"/><limit lower="-1" upper="1" effort="9"/><mimic joint="left" multiplier="-2" offset="0.01"/></joint>
  <joint name="turn" type="revolute"><parent link="palm"/><child link="wrist"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9"/></joint>
</robot>
)";
  }

  Task task(const std::string& joints) const {
    return parse_task(R"(
scene:
  robots:
    - {name: l, urdf: gripper.urdf, stiffness: 100, base: {position: [0, 0, 1]}}
    - {name: r, urdf: gripper.urdf, stiffness: 100}
  objects: [{name: box, joint: free, mass: 0.1, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}]
start: {objects: {box: {position: [0.3, 0, 0]}}, joints: )" +
                          joints + R"(}
goal: {objects: {box: {position: [0.4, 0, 0]}}}
tolerance: {position: 0.01, angle: 0.1}
)",
                      dir_);
  }

  std::string message(const std::string& joints) const {
    return message_of([&] { (void)task(joints); });
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& dir_ = temporary_.path();
};

TEST_F(StartSection, ListWithFollowers_IsThatWithoutThem) {
  const Eigen::VectorXd q = task("[0.004, 0.3, -0.004, 0.2]").problem.q_start;
  EXPECT_EQ(q.tail(4), Eigen::Vector4d(0.004, 0.3, -0.004, 0.2));
  const Task all = task("[0.004, 0.002, 0.3, -0.004, 0.018, 0.2]");
  EXPECT_EQ(all.problem.q_start, q);
  EXPECT_EQ(all.model->scene().rest, (std::vector<double>{0.004, 0.3, -0.004, 0.2}));
  EXPECT_EQ(task("{l/left: 0.004, l/right: 0.002, l/turn: 0.3, r/left: -0.004, r/turn: 0.2}").problem.q_start, q);
}

TEST_F(StartSection, FollowerElsewhere_SaysWhereItIs) {
  const std::string right = "expected 0.018, as it follows r/left, or no number for it";
  EXPECT_EQ(message("[0.004, 0.002, 0.3, -0.004, 0.004, 0.2]"), "start.joints: got r/right = 0.004, " + right);
  EXPECT_EQ(message("{r/left: -0.004, r/right: 0.1}"), "start.joints.r/right: got r/right = 0.1, " + right);
}

TEST_F(StartSection, ListOfAnotherLength_NamesTheJoints) {
  const std::string expected =
      "expected a list of 4 numbers (l/left, l/turn, r/left, r/turn), or of 6 with the joints that follow others (l/right, r/right)";
  EXPECT_EQ(message("[0, 0]"), "start.joints: got a list of 2, " + expected);
  EXPECT_EQ(message("[0, 0, 0, 0, 0, 0, 0]"),
            "start.joints: got a list of 7, " + expected + "; a joint whose limits are the same stands still and has no number");
}

TEST_F(StartSection, AngleInDegrees_IsSaidInRadians) {
  EXPECT_EQ(message("{l/turn: 30}"),
            "start.joints: got l/turn = 30, expected a start inside the joint limits [-1, 1]; angles are in radians, 30° = 0.5236 rad");
  EXPECT_EQ(message("{l/turn: 1.5}"), "start.joints: got l/turn = 1.5, expected a start inside the joint limits [-1, 1]");
  EXPECT_EQ(message("{l/left: 3}"), "start.joints: got l/left = 3, expected a start inside the joint limits [-0.02, 0.02]")
      << "of a slider";
}

TEST_F(StartSection, UnknownJoint_IsNamed) {
  EXPECT_NE(message("{l/lift: 0}").find("start.joints.l/lift: joint: got unknown name 'l/lift'"), std::string::npos)
      << message("{l/lift: 0}");
}

/// What is wrong in one section does not hide what is wrong in another.
TEST_F(StartSection, FaultsOfAllSections_AreNamedTogether) {
  const std::string text = R"(
colour: red
scene:
  robots: [{name: l, urdf: gripper.urdf, stiffness: 100}]
  objects: [{name: box, joint: free, mass: 0.1, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}]
start: {objects: {box: {position: [0.3, 0]}, can: {position: [0, 0, 0]}}, joints: {l/turn: 3}}
goal: {objects: {box: {position: [0.4, 0, x]}}}
tolerance: {position: -1, angle: 0}
planner: {goal_bias: 2, anytime: 1}
)";
  EXPECT_EQ(message_of([&] { (void)parse_task(text, dir_); }),
            "colour: got an unknown key, expected one of name, description, scene, start, goal, tolerance, bystanders, planner, optimize\n"
            "tolerance.position: got -1, expected a number > 0\n"
            "tolerance.angle: got 0, expected a number > 0\n"
            "start.objects.box.position: got a list of 2, expected a list of 3 numbers\n"
            "start.objects.can: got unknown object 'can', expected one of box\n"
            "start.joints: got l/turn = 3, expected a start inside the joint limits [-1, 1]\n"
            "goal.objects.box.position[2]: got 'x', expected a number\n"
            "planner.anytime: got 1, expected true or false\n"
            "planner.goal_bias: got 2, expected a probability in [0, 1]");
  std::string unread = text;
  unread.replace(unread.find("mass: 0.1"), 9, "mass: 0");
  EXPECT_EQ(message_of([&] { (void)parse_task(unread, dir_); }),
            "colour: got an unknown key, expected one of name, description, scene, start, goal, tolerance, bystanders, planner, optimize\n"
            "tolerance.position: got -1, expected a number > 0\n"
            "tolerance.angle: got 0, expected a number > 0\n"
            "scene.objects[0].mass: got 0, expected a number > 0");
}

/// The tip of a finger that a tendon leaves 1/7 rad of room beside the next joint may be given anywhere in it.
TEST_F(StartSection, JointThatATendonKeepsNearAnother_MayBeGivenWhereTheTendonLetsIt) {
  std::ofstream(dir_ / "finger.xml")
      << R"(<mujoco><compiler angle="radian"/><worldbody><body><joint name="middle" range="0 1.5"/><geom size=".05"/>
    <body pos=".3 0 0"><joint name="tip" range="0 1.7"/><geom size=".05"/></body></body></worldbody>
    <tendon><fixed name="c" range="-.001 .001"><joint joint="tip" coef=".007"/><joint joint="middle" coef="-.007"/></fixed></tendon>
    <actuator><position joint="middle"/></actuator></mujoco>)";
  const auto message_at = [&](double tip) {
    const std::string joints = "{middle: 0.5, tip: " + std::to_string(tip) + "}";
    return message_of([&] {
      (void)parse_task(
          "scene: {robots: [{name: f, mjcf: finger.xml}], objects: [{name: box, joint: free, mass: 0.1, shapes: [{sphere: {radius: "
          "0.1}}]}]}\n"
          "start: {objects: {box: {position: [3, 0, 0]}}, joints: " +
              joints +
              "}\n"
              "goal: {objects: {box: {position: [4, 0, 0]}}}\ntolerance: {position: 0.01, angle: 0.1}\n",
          dir_);
    });
  };
  for (const double tip : {0.5, 0.37, 0.64}) EXPECT_EQ(message_at(tip), "no exception") << tip;
  for (const double tip : {0.3, 0.7})
    EXPECT_NE(message_at(tip).find("expected 0.5, as it follows f/middle"), std::string::npos) << message_at(tip);
}

}  // namespace
}  // namespace stiction::tasks
