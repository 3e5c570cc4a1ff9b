// Guarded moves before a run: fixed bodies of a task that are elsewhere, and a table with a block on it that an arm feels before it pushes the block.
#include "stiction/tasks/touch_first.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "stiction/tasks/touch_scenario_file.hpp"
#include "support/message_of.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::tasks::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using stiction::test::message_of;
using stiction::test::source_dir;

Task push() { return load_task((source_dir() / "tasks/ur5_mesh_push.yaml").string()); }
std::filesystem::path moves() { return source_dir() / "scenarios/feel_table.yaml"; }

double height_of(const world::Model& model) {
  return std::ranges::find(model.scene().fixed, std::string("table"), &world::FixedSpec::name)->X_WB.p.z();
}

std::string text_of_moves() {
  std::ifstream in(moves());
  std::string out((std::istreambuf_iterator<char>(in)), {});
  const std::string relative = "../tasks";
  return out.replace(out.find(relative), relative.size(), (source_dir() / "tasks").string());
}

/// The scenario of a changed text.
execution::TouchScenario load(const std::string& text, const Task& task) {
  const auto file = stiction::test::folder_of_the_process() / "moves.yaml";
  std::ofstream(file) << text;
  return load_touch_scenario(file, task);
}

TEST(Places, FixedBodyIsElsewhere_AndTheTextOfTheTaskSaysSo) {
  Task task = push();
  const std::string before = task.scene_sha256;
  set_places(task, {{"table", Vector3d(0, 0, 0.0123456789012345)}});
  EXPECT_EQ(height_of(*task.model), 0.0123456789012345);
  EXPECT_EQ(task.problem.model, task.model);
  EXPECT_NE(task.scene_sha256, before);
  const Task again = parse_task(task.text, task.file);
  EXPECT_EQ(again.scene_sha256, task.scene_sha256);
  EXPECT_EQ(again.name, "ur5_mesh_push");
  EXPECT_EQ(again.problem.q_start, task.problem.q_start);
}

TEST(Places, WhatIsNoFixedBody_IsNamed) {
  Task task = push();
  EXPECT_NE(message_of([&] { set_places(task, {{"block", Vector3d::Zero()}}); }).find("places: got 'block'"), std::string::npos);
  const std::string text = R"({"base": "ur5_mesh_push.yaml", "scene": {"places": {"tabel": [0, 0, 0]}}})";
  const std::string message = message_of([&] { (void)parse_task(text, source_dir() / "tasks"); });
  EXPECT_NE(message.find("scene.places.tabel"), std::string::npos) << message;
  EXPECT_NE(message.find("expected one of table"), std::string::npos) << message;
}

class TouchFirst : public testing::TestWithParam<std::uint64_t> {};

TEST_P(TouchFirst, TableIsFound_AndBlockAndGoalGoWithIt) {
  Task task = push();
  const Task known = task;
  execution::GuardedRunResult out;
  execution::TouchRunOptions options;
  options.seed = GetParam();
  const execution::TouchScenario scenario = load_touch_scenario(moves(), task);
  ASSERT_EQ(touch_first(scenario, {}, options, task, out), Status::Solved) << out.reason;
  ASSERT_TRUE(out.reached) << out.reason;
  const double really = height_of(*out.world), found = height_of(*task.model);
  EXPECT_GT(std::abs(really), 5e-3) << "the height was right: the test would say nothing";
  EXPECT_NEAR(found, really, 3e-3);
  EXPECT_LE(out.moves[2].late_peak, 1.2 * 5);
  EXPECT_EQ(task.model, task.problem.model);
  EXPECT_EQ(task.problem.q_start, out.q) << "the run goes on from where things are";
  const int block = task.problem.goal.object;
  EXPECT_NEAR((world::object_pose(*out.world, out.q, block).p - world::object_pose(*known.model, known.problem.q_start, block).p).z(),
              really, 1e-3)
      << "the block stands on the table";
  EXPECT_NEAR((task.problem.goal.X_WG.p - known.problem.goal.X_WG.p - Vector3d(0, 0, found)).norm(), 0, 1e-12);
  EXPECT_NEAR(task.problem.q_goal[2] - known.problem.q_goal[2], found, 1e-12);
}
INSTANTIATE_TEST_SUITE_P(Seeds, TouchFirst, testing::Values(1, 2));

TEST(TouchFirstCase, WithoutMoves_TheWorldDiffersAndNothingIsCorrected) {
  Task task = push();
  std::string text = text_of_moves();
  text.erase(text.find("moves:"), text.find("controller:") - text.find("moves:"));
  execution::TouchRunOptions options;
  options.seed = 1;
  execution::GuardedRunResult out;
  const execution::TouchScenario scenario = load(text, task);
  ASSERT_EQ(touch_first(scenario, {}, options, task, out), Status::Solved);
  EXPECT_TRUE(out.reached);
  EXPECT_EQ(height_of(*task.model), 0);
  EXPECT_GT(std::abs(height_of(*out.world)), 5e-3);
  EXPECT_NEAR(task.problem.q_start[2] - push().problem.q_start[2], height_of(*out.world), 1e-12) << "the block stands on the table";
}

TEST(TouchFirstCase, BadInput_NamesFileAndField) {
  const Task task = push();
  const std::string good = text_of_moves();
  const auto message = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    EXPECT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    const std::string out = message_of([&] { (void)load(text, task); });
    EXPECT_NE(out.find("moves.yaml"), std::string::npos) << out;
    return out;
  };
  EXPECT_NE(message("objects: [block]", "objects: [blok]").find("misplaced[0].objects[0]"), std::string::npos);
  EXPECT_NE(message("tool:", "start: [0, 0, 0, 0, 0, 0]\ntool:").find("start: got start beside task"), std::string::npos);
  EXPECT_NE(message("tool:", "goal: [0, 0, 0, 0, 0, 0]\ntool:").find("goal: got a posture to go to, expected moves"), std::string::npos);
  const std::string own = message_of([&] { (void)load_touch_scenario(source_dir() / "scenarios/lower_until_touch.yaml", task); });
  EXPECT_NE(own.find("scene: got a scene of its own, expected `task: ur5_mesh_push`"), std::string::npos) << own;
}

}  // namespace
}  // namespace stiction::tasks::test
