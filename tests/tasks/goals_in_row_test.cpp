// Goals that a run reaches one after another: numbers, files, what each begins with, and what is said of a wrong one.
#include "stiction/tasks/goals_in_row.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::tasks {
namespace {

using Eigen::Vector3d;
using planning::PlanningProblem;
using stiction::test::message_of;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A ball, two boxes in a plane and a bystander that may not move.
class GoalsInRow : public testing::Test {
 protected:
  Task task(const std::string& more = "") const {
    return parse_task(R"(
scene:
  robots:
    - {name: ball, urdf: ball.urdf, stiffness: 100}
  objects:
    - {name: a, joint: planar_xy, mass: 1, shapes: [{box: {size: [0.2, 0.2, 0.2]}}]}
    - {name: b, joint: planar_xy, mass: 1, shapes: [{box: {size: [0.2, 0.2, 0.2]}}]}
  fixed: [{name: wall, shapes: [{box: {size: [0.2, 2, 2]}}], pose: {position: [3, 0, 0]}}]
start: {objects: {a: {coordinates: [0, 0, 0]}, b: {coordinates: [1, 0, 0]}}}
goal: {objects: {a: {coordinates: [0.5, 0.5, 0]}}}
tolerance: {position: 0.01, angle: 0.1}
)" + more,
                      dir_);
  }
  void SetUp() override {
    std::ofstream(dir_ / "ball.urdf") << R"(<robot name="ball"><link name="base"/><link name="x"/>
  <link name="tip"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <joint name="jx" type="prismatic"><parent link="base"/><child link="x"/><axis xyz="1 0 0"/><origin xyz="0 -1 0"/><limit lower="-3" upper="3" effort="9"/></joint>
  <joint name="jy" type="prismatic"><parent link="x"/><child link="tip"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="9"/></joint>
</robot>
)";
  }
  std::filesystem::path file(const std::string& text) const {
    std::ofstream(dir_ / "goals.yaml") << text;
    return dir_ / "goals.yaml";
  }
  std::string complaint(const std::string& text) const {
    const Task given = task();
    return message_of([&] { (void)load_goals(given, file(text)); });
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& dir_ = temporary_.path();
};

TEST_F(GoalsInRow, NumbersAndSections_AreGoals) {
  const auto goals = load_goals(task(), file("- [0.1, 0.2, 0.3]\n- {objects: {a: {coordinates: [0.4, ~, ~]}}}\n- [0.5, ~, 0]\n"));
  ASSERT_EQ(goals.size(), 3U);
  EXPECT_FALSE(goals[0].goal.region);
  EXPECT_LT((goals[0].q_goal.head(3) - Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12);
  ASSERT_TRUE(goals[1].goal.region);
  EXPECT_EQ(goals[1].goal.region->upper[1], kInfinity);
  EXPECT_LT((goals[1].q_goal.head(3) - Vector3d(0.4, 0.2, 0.3)).norm(), 1e-12) << "what is open stays where the goal before left it";
  EXPECT_LT((goals[2].q_goal.head(3) - Vector3d(0.5, 0.2, 0)).norm(), 1e-12);
  for (const PlanningProblem& each : goals) {
    EXPECT_EQ(each.goal.tol_position, 0.01);
    EXPECT_NO_THROW(each.validate());
  }
}

/// The second object is pushed while the first one stays where it was brought, and the first is no bystander at its start.
TEST_F(GoalsInRow, EachBeginsWhereTheOneBeforeEnded) {
  const auto goals =
      parse_goals(task("bystanders: {may_move: 0.05}\n"), "[[0, 1, 0], {objects: {b: {coordinates: [1, 1, 0]}}}, [0.2, 1, 0]]", "goals");
  ASSERT_EQ(goals.size(), 3U);
  EXPECT_EQ(goals[1].goal.object, 1);
  EXPECT_LT((goals[1].q_goal.head(3) - Vector3d(0, 1, 0)).norm(), 1e-12);
  ASSERT_TRUE(goals[1].goal.bystanders);
  EXPECT_EQ(goals[1].goal.bystanders->objects, std::vector<int>{0});
  EXPECT_LT((goals[1].goal.bystanders->q_u.head(3) - Vector3d(0, 1, 0)).norm(), 1e-12);
  EXPECT_EQ(goals[2].goal.object, 0) << "numbers are those of the objects of the task";
  EXPECT_LT((goals[2].q_goal.segment<3>(3) - Vector3d(1, 1, 0)).norm(), 1e-12);
}

TEST_F(GoalsInRow, OneGoalInNumbers_IsThatOfSetGoal) {
  Task one = task();
  const auto goals = make_goals(one, {{0.1, 0.2, 0.3}}, "--goal");
  set_goal(one, std::vector<std::optional<double>>{0.1, 0.2, 0.3});
  ASSERT_EQ(goals.size(), 1U);
  EXPECT_EQ(goals[0].q_goal, one.problem.q_goal);
  EXPECT_EQ(goals[0].goal.X_WG.p, one.problem.goal.X_WG.p);
  EXPECT_EQ(message_of([&] { (void)make_goals(one, {{1.0}}, "--goal"); }), "goal: got 1 numbers, expected 3 (the coordinates of 'a')");
}

TEST_F(GoalsInRow, AWrongOne_IsNamedWithItsNumberAndPlace) {
  const std::string here = " in " + (dir_ / "goals.yaml").string();
  const std::string good = "- [0, 1, 0]\n- [0, 2, 0]\n";
  EXPECT_EQ(complaint(good + "- [1, 2]\n"), "goal 3 of 3" + here + ":3: got 2 numbers, expected 3 (the coordinates of 'a')");
  EXPECT_EQ(complaint(good + "- [1, 2, x]\n- [0, 1, 0]\n"), "goal 3 of 4" + here + ":3: [2][2]: got 'x', expected a number");
  EXPECT_EQ(complaint(good + "- 7\n"),
            "goal 3 of 3" + here + ":3: [2]: got 7, expected a list of numbers, or what the goal of a task may be");
  EXPECT_NE(complaint(good + "- {objects: {c: {coordinates: [0, 0, 0]}}}\n").find("goal 3 of 3" + here + ":3: [2].objects.c: got"),
            std::string::npos)
      << complaint(good + "- {objects: {c: {coordinates: [0, 0, 0]}}}\n");
  EXPECT_NE(complaint(good + "- [3, 0, 0]\n").find("goal 3 of 3" + here + ":3: got a pose in which 'a"), std::string::npos)
      << complaint(good + "- [3, 0, 0]\n");
  EXPECT_EQ(complaint("[]"), (dir_ / "goals.yaml").string() + ": got an empty list, expected a list of goals");
  EXPECT_NE(complaint("goals: 3").find("expected a list of goals"), std::string::npos);
  const Task given = task();
  EXPECT_EQ(message_of([&] { (void)parse_goals(given, "[[0, 1, 0], [1]]", "goals"); }),
            "goals[1]: got 1 numbers, expected 3 (the coordinates of 'a')");
  EXPECT_EQ(message_of([&] { (void)parse_goals(given, "[[0, 1, 0], [0, 1, true]]", "goals"); }),
            "goals[1][2]: got 'true', expected a number");
  EXPECT_EQ(message_of([&] {
              (void)make_goals(given, {{0.0, 1.0, 0.0}, {1.0}}, "--goal");
            }),
            "--goal 2 of 2: got 1 numbers, expected 3 (the coordinates of 'a')");
}

}  // namespace
}  // namespace stiction::tasks
