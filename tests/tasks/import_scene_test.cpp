// Tasks of scenes that are in one MJCF file: where they start, what their goals are, and the text of an import.
#include "stiction/tasks/import_scene.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "stiction/dynamics/step.hpp"
#include "stiction/tasks/lint.hpp"
#include "stiction/tasks/task.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;
using stiction::test::message_of;

constexpr const char* kScene = R"(<mujoco><compiler angle="radian"/><worldbody>
  <geom name="floor" type="plane" size="1 1 1"/>
  <body name="base" pos="0 0 .5"><joint name="yaw" axis="0 0 1" range="-2 2" ref=".2"/><geom type="capsule" size=".04" fromto="0 0 0 .3 0 0"/>
    <body name="hand" pos=".3 0 0"><joint name="lift" type="slide" axis="0 0 1" range="-.4 .4"/><geom size=".03"/><site name="palm"/></body></body>
  <body name="case" pos="1 0 .3"><body name="drawer"><joint name="rail" type="slide" axis="1 0 0" range="-.3 0"/><geom type="box" size=".1 .1 .05"/></body></body>
  <body name="cube" pos="0 .5 .05" euler="0 0 .3"><freejoint/><geom type="box" size=".05 .05 .05"/></body>
  <site name="goal_place" pos=".2 .6 .05" euler="0 0 1"/><site name="edge" pos="0 0 1"/>
</worldbody><actuator><position joint="yaw" kp="100"/><position joint="lift" kp="400"/></actuator>
<keyframe><key name="home" qpos=".7 .1 -.2 0 .4 .05 1 0 0 0"/><key name="away" qpos="0 0 0 0 .4 .05 1 0 0 0"/></keyframe></mujoco>)";

class WholeSceneTask : public testing::Test {
 protected:
  void SetUp() override { std::ofstream(dir_ / "scene.xml") << kScene; }

  Task task(const std::string& start, const std::string& goal = "{objects: {drawer: {coordinates: [-0.2]}}}") const {
    return parse_task("scene: {file: scene.xml}\n" + start + "\ngoal: " + goal + "\ntolerance: {position: 0.01, angle: 0.1}\n", dir_);
  }
  std::string refused(const std::string& start, const std::string& goal = "{objects: {drawer: {coordinates: [-0.2]}}}") const {
    return message_of([&] { (void)task(start, goal); });
  }

  const stiction::test::TemporaryFolder temporary_;
  const fs::path& dir_ = temporary_.path();
};

Eigen::VectorXd numbers(std::initializer_list<double> values) {
  return Eigen::Map<const Eigen::VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

TEST_F(WholeSceneTask, WithoutAStart_StartsAsTheFileHasIt) {
  const Eigen::VectorXd q = task("").problem.q_start;
  EXPECT_TRUE(q.isApprox(numbers({0, 0, 0.5, 0.05, 0, 0, std::sin(0.15), std::cos(0.15), 0.2, 0}), 1e-12)) << q.transpose();
}

TEST_F(WholeSceneTask, Keyframe_IsTheStartAndOtherKeysGoBeforeIt) {
  EXPECT_TRUE(task("start: {keyframe: home}").problem.q_start.isApprox(numbers({-0.2, 0, 0.4, 0.05, 0, 0, 0, 1, 0.7, 0.1}), 1e-12));
  const Task changed = task("start: {keyframe: home, joints: {yaw: -1}, objects: {drawer: {coordinates: [-0.1]}}}");
  EXPECT_TRUE(changed.problem.q_start.isApprox(numbers({-0.1, 0, 0.4, 0.05, 0, 0, 0, 1, -1, 0.1}), 1e-12));
  const std::string message = refused("start: {keyframe: hom}");
  EXPECT_NE(message.find("start.keyframe: got unknown keyframe 'hom', expected one of home, away; did you mean 'home'?"), std::string::npos)
      << message;
}

/// Yaw and lift put the hand at (0.3 cos, 0.3 sin, z), with yaw 0.2 along x: the posture is known.
TEST_F(WholeSceneTask, PoseOfALink_GivesTheJoints) {
  const Task reached = task("start: {poses: {hand: {position: [0.18, 0.24, 0.7]}}}");
  EXPECT_TRUE(reached.problem.q_start.tail(2).isApprox(numbers({0.2 + std::atan2(0.24, 0.18), 0.2}), 1e-6))
      << reached.problem.q_start.transpose();
  const Task turned = task("start: {poses: {robot/hand: {position: [0.18, 0.24, 0.7], rpy: [0, 0, 0.9272952]}}}");
  EXPECT_TRUE(turned.problem.q_start.tail(2).isApprox(numbers({1.1272952, 0.2}), 1e-5));
}

TEST_F(WholeSceneTask, PosesThatAreNotReached_SayHowFarTheyAre) {
  const std::string far = refused("start: {poses: {hand: {position: [0.6, 0, 0.5]}}}");
  EXPECT_NE(far.find("start.poses: got poses of 'hand' that were not reached: the nearest posture found is 0.3 m and 0 rad off"),
            std::string::npos)
      << far;
  const std::string turned = refused("start: {poses: {hand: {position: [0.3, 0, 0.5], rpy: [1, 0, 0]}}}");
  EXPECT_NE(turned.find("that were not reached"), std::string::npos) << turned;
  const std::string unknown = refused("start: {poses: {hnd: {position: [0.3, 0, 0.5]}}}");
  EXPECT_NE(unknown.find("unknown link that moves 'hnd'"), std::string::npos) << unknown;
  // The cube is where the hand would be: nothing else reaches that point.
  const std::string inside =
      refused("start: {objects: {cube: {position: [0.18, 0.24, 0.5]}}, poses: {hand: {position: [0.18, 0.24, 0.5]}}}");
  EXPECT_NE(inside.find("reached in contact alone: "), std::string::npos) << inside;
  EXPECT_NE(inside.find("'cube/box_0'"), std::string::npos) << inside;
}

/// A body that no task moves stands still where the file has it, whatever the keyframe says.
TEST_F(WholeSceneTask, KeyframeOfABodyThatStandsStill_IsNamed) {
  const auto with = [&](const std::string& objects) {
    return parse_task("scene: {file: scene.xml, objects: " + objects +
                          "}\nstart: {keyframe: home}\ngoal: {objects: {drawer: {coordinates: [-0.2]}}}\ntolerance: {position: 0.01, "
                          "angle: 0.1}\n",
                      dir_)
        .notes;
  };
  EXPECT_TRUE(with("[drawer, cube]").empty());
  ASSERT_EQ(with("[drawer]").size(), 1U);
  EXPECT_NE(with("[drawer]")[0].find("start.keyframe: keyframe 'home' moves cube, which stands still at the pose of the file"),
            std::string::npos)
      << with("[drawer]")[0];
}

TEST_F(WholeSceneTask, PlanarObjectAtASite_HasItsBodyThere) {
  std::ofstream(dir_ / "puck.xml") << R"(<mujoco><compiler angle="radian"/><worldbody><site name="target" pos=".1 .35 1" euler="0 0 .3"/>
    <body name="base" pos="0 .9 1"><joint name="j" axis="0 0 1" range="-2 2"/><geom type="capsule" size=".02" fromto="0 .02 0 0 .8 0"/></body>
    <body name="puck" pos="0 .3 1"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint axis="0 0 1" pos=".2 0 0" ref=".5"/>
      <geom name="g" type="box" size=".05 .02 .01" mass=".7"/></body></worldbody><actuator><position joint="j" kp="10"/></actuator></mujoco>)";
  const Task task =
      parse_task("scene: {file: puck.xml}\ngoal: {object: puck, at: target}\ntolerance: {position: 0.01, angle: 0.1}\n", dir_);
  Eigen::VectorXd q = task.problem.q_start;
  q.head(3) = task.problem.q_goal.head(3);
  const auto& geometries = task.model->geometries();
  const auto box = std::ranges::find_if(geometries, [](const auto& geometry) { return geometry.name == "puck/g"; });
  ASSERT_NE(box, geometries.end());
  const world::Pose X_WG = world::object_pose(*task.model, q, 0) * box->X_BG;
  EXPECT_TRUE(X_WG.p.isApprox(Eigen::Vector3d(0.1, 0.35, 1), 1e-12)) << X_WG.p.transpose();
  EXPECT_NEAR(X_WG.R(0, 0), std::cos(0.3), 1e-12);
}

TEST_F(WholeSceneTask, PlacesOfTheScene_MoveItsSitesAsWell) {
  const Task moved = parse_task(
      "scene: {file: scene.xml, places: {robot_world: [0, 0, 0.1]}}\ngoal: {object: cube, at: goal_place}\ntolerance: {position: 0.01, "
      "angle: 0.1}\n",
      dir_);
  EXPECT_TRUE(moved.problem.goal.X_WG.p.isApprox(Eigen::Vector3d(0.2, 0.6, 0.15))) << moved.problem.goal.X_WG.p.transpose();
}

TEST_F(WholeSceneTask, GoalAtASite_IsItsPose) {
  const Task at = task("", "{object: cube, at: goal_place}");
  EXPECT_EQ(at.model->objects()[static_cast<std::size_t>(at.problem.goal.object)].name, "cube");
  EXPECT_TRUE(at.problem.goal.X_WG.p.isApprox(Eigen::Vector3d(0.2, 0.6, 0.05)));
  EXPECT_NEAR(at.problem.goal.X_WG.R(0, 0), std::cos(1), 1e-12);
  EXPECT_FALSE(at.problem.goal.region.has_value());
  const Task open = task("", "{object: cube, at: goal_place, rpy: ~}");
  ASSERT_TRUE(open.problem.goal.region.has_value());
  EXPECT_TRUE(open.problem.goal.X_WG.p.isApprox(Eigen::Vector3d(0.2, 0.6, 0.05)));
  EXPECT_NEAR(open.problem.goal.X_WG.R(0, 0), std::cos(0.3), 1e-9) << "as it starts";
}

TEST_F(WholeSceneTask, GoalsThatAreNone_AreNamed) {
  EXPECT_NE(refused("", "{object: cube, at: palm}").find("'palm', which moves with the robot's link 'hand'"), std::string::npos)
      << refused("", "{object: cube, at: palm}");
  EXPECT_NE(refused("", "{object: cube, at: drawer}").find("'drawer', which moves with the object 'drawer'"), std::string::npos);
  EXPECT_NE(refused("", "{object: cube, at: goal_plac}").find("did you mean 'goal_place'?"), std::string::npos);
  EXPECT_NE(refused("", "{object: drawer, at: edge}").find("which is on a hinge or a slider, expected objects: {drawer: {coordinates:"),
            std::string::npos);
}

/// Success tests of the field say that a coordinate is beyond a value.
TEST_F(WholeSceneTask, GoalRegion_MayBeOpenToOneSide) {
  const Task beyond = task("", "{objects: {drawer: {coordinates: [[~, -0.15]]}}}");
  ASSERT_TRUE(beyond.problem.goal.region.has_value());
  EXPECT_EQ(beyond.problem.q_goal[0], -0.15) << "the nearest to the start";
  EXPECT_EQ(beyond.problem.goal.region->upper[0], -0.15);
  EXPECT_TRUE(std::isinf(beyond.problem.goal.region->lower[0]));
}

TEST_F(WholeSceneTask, Import_WritesATaskThatLoadsAsTheFileIs) {
  const std::string other = import_scene(dir_ / "scene.xml", dir_, "cube");
  EXPECT_NE(other.find("goal: {object: cube, at: goal_place, rpy: ~}"), std::string::npos) << other;
  EXPECT_NE(message_of([&] { (void)import_scene(dir_ / "scene.xml", dir_, "cub"); }).find("object: got 'cub', expected one of"),
            std::string::npos);
  EXPECT_EQ(list_keyframes(dir_ / "scene.xml"), (std::vector<std::string>{"home", "away"}));
  const std::string text = import_scene(dir_ / "scene.xml", dir_);
  EXPECT_EQ(text, R"(# Robot: 2 joints (yaw, lift).
# Objects, and the only bodies that move beside it: drawer (slider [-0.3, 0]), cube (free).
# Keyframes: home, away.
# Places for `at` of a goal: goal_place, edge, case.
scene:
  file: "scene.xml"
  objects: [drawer, cube]
start: {keyframe: home}
goal: {objects: {drawer: {coordinates: [-0.02]}}}  # to be edited
tolerance: {position: 0.01, angle: 0.1}
)");
  const Task imported = parse_task(text, dir_);
  EXPECT_EQ(imported.problem.q_start, task("start: {keyframe: home}").problem.q_start);
  EXPECT_EQ(imported.scene_sha256, task("start: {keyframe: home}").scene_sha256) << "naming all objects changes nothing";
}

TEST_F(WholeSceneTask, ImportOfAFloatingRobot_FixesItsBase) {
  std::ofstream(dir_ / "floating.xml") << R"(<mujoco><worldbody><body name="torso" pos="0 0 1"><freejoint/><geom size=".1"/>
      <body name="arm"><joint name="j"/><geom size=".05" pos=".3 0 0"/></body></body>
      <body name="ball" pos="1 0 0"><freejoint/><geom size=".1"/></body><site name="target" pos="1 1 0"/></worldbody><actuator><motor joint="j"/></actuator></mujoco>)";
  const std::string text = import_scene(dir_ / "floating.xml", dir_);
  EXPECT_NE(text.find("  robot: {fixed_base: true}\n"), std::string::npos) << text;
  EXPECT_NE(text.find("goal: {object: ball, at: target, rpy: ~}"), std::string::npos) << text;
  EXPECT_EQ(parse_task(text, dir_).model->n_a(), 1);
}

/// Names that YAML would read otherwise, or that the scene uses itself.
TEST_F(WholeSceneTask, ImportOfOddNames_LoadsAgain) {
  for (const char* name : {"my: cube #1", "a&#10;b&#9;c", "no", "1", "a&quot;b\\c", "o/cube", "robot", "robot_world"}) {
    const fs::path file = dir_ / "odd \"names\" \\.xml";
    std::ofstream(file) << fmt::format(R"(<mujoco><worldbody><body name="arm"><joint name="j&#10;k"/><geom size=".1"/></body>
        <body name="{}" pos="1 0 0"><freejoint/><geom size=".1"/></body><site name="p&#10;q" pos="0 0 9"/></worldbody>
        <actuator><motor joint="j&#10;k"/></actuator><keyframe><key name="k&#10;l"/><key name="m"/></keyframe></mujoco>)",
                                       name);
    const std::string text = import_scene(file, dir_);
    EXPECT_EQ(message_of([&] { EXPECT_EQ(parse_task(text, dir_).model->objects().size(), 1u); }), "no exception") << text;
  }
}

TEST_F(WholeSceneTask, ImportOfWhatIsNoScene_SaysWhy) {
  std::ofstream(dir_ / "robot.xml")
      << R"(<mujoco><worldbody><body><joint name="j"/><geom size=".1"/></body></worldbody><actuator><motor joint="j"/></actuator></mujoco>)";
  std::ofstream(dir_ / "object.xml") << R"(<mujoco><worldbody><body><joint name="j"/><geom size=".1"/></body></worldbody></mujoco>)";
  EXPECT_NE(message_of([&] { (void)import_scene(dir_ / "robot.xml", dir_); }).find("got a file without an object"), std::string::npos);
  const std::string object = message_of([&] { (void)import_scene(dir_ / "object.xml", dir_); });
  EXPECT_NE(object.find("object.xml: import: got a file without a robot, expected a joint with an actuator, or a task with `robot: "
                        "{bodies: […]}` beside its "
                        "`file`, for one of body_1"),
            std::string::npos)
      << object;
  std::ofstream(dir_ / "loop.xml") << R"(<mujoco><include file="again.xml"/></mujoco>)";
  std::ofstream(dir_ / "again.xml") << R"(<mujocoinclude><include file="loop.xml"/></mujocoinclude>)";
  const std::string loop = message_of([&] { (void)import_scene(dir_ / "loop.xml", dir_); });
  EXPECT_NE(loop.find("File 'again.xml' already included"), std::string::npos) << loop;
  std::ofstream(dir_ / "longer.xml") << R"(<mujoco><worldbody><body><joint name="j"/><geom size=".1"/></body></worldbody>
      <actuator><motor joint="j"/></actuator><keyframe><key name="of_another_model" qpos="1 2 3"/></keyframe></mujoco>)";
  const std::string key = message_of([&] { (void)import_scene(dir_ / "longer.xml", dir_); });
  EXPECT_NE(key.find("keyframe 'of_another_model': invalid qpos size, expected 1, got 3"), std::string::npos) << key;
  EXPECT_NE(message_of([&] { (void)import_scene(dir_ / "nowhere.xml", dir_); }).find("a file that does not exist"), std::string::npos);
}

TEST_F(WholeSceneTask, TwoArmsOfOneTree_AreOneRobot) {
  std::ofstream(dir_ / "arms.xml")
      << R"(<mujoco><worldbody><body name="torso"><body name="left" pos="1 0 0"><joint name="l"/><geom size=".1"/></body>
      <body name="right" pos="-1 0 0"><joint name="r"/><geom size=".1"/></body></body><body name="box" pos="0 2 0"><freejoint/><geom size=".1"/></body>
      </worldbody><actuator><motor joint="l"/><motor joint="r"/></actuator></mujoco>)";
  const Task arms = parse_task(import_scene(dir_ / "arms.xml", dir_), dir_);
  EXPECT_EQ(arms.model->n_a(), 2);
  EXPECT_EQ(arms.model->robots().size(), 1u);
}

/// It loads, and says in the end what a step can hold.
TEST_F(WholeSceneTask, MoreBodiesThanAStepHolds_AreNamed) {
  std::string bodies;
  for (int i = 0; i < 200; ++i) bodies += fmt::format("<body pos='{} 0 1'><freejoint/><geom size='.1'/></body>", i);
  std::ofstream(dir_ / "many.xml") << "<mujoco><worldbody><body name='arm' pos='0 3 0'><joint name='j'/><geom size='.1'/></body>" << bodies
                                   << "</worldbody><actuator><motor joint='j'/></actuator></mujoco>";
  const Task many = parse_task(import_scene(dir_ / "many.xml", dir_), dir_);
  const std::string message = message_of([&] { dynamics::StepWorkspace work(many.model); });
  EXPECT_EQ(
      message,
      "model: got 200 objects and 1 joints that move, with 1201 coordinates, expected at most 1024 in groups of 4, of which a free object "
      "has two, for a step; let bodies stand still that need not move (`objects` of a scene's `file`)");
}

}  // namespace
}  // namespace stiction::tasks
