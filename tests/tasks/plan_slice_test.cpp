#include "stiction/tasks/plan_slice.hpp"

#include <gtest/gtest.h>

#include <set>

#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/check.hpp"
#include "tasks/scripted_plan.hpp"

namespace stiction::tasks {
namespace {

TEST(PlanSlice, AllSegments_AreThePlan) {
  const ScriptedPlan plan = push_box();  // it comes near, pushes, leaves
  EXPECT_EQ(to_text(slice(plan.task, plan.file, 0, plan.file.segments.size())), to_text(plan.file));
}

TEST(PlanSlice, LaterSegments_StartWhereTheEarlierOnesEnd) {
  const ScriptedPlan plan = push_box();  // it comes near, pushes, leaves
  const PlanFile& whole = plan.file;
  const std::size_t count = whole.segments.size();
  const PlanFile first = slice(plan.task, whole, 0, 1), last = slice(plan.task, whole, 1, count);
  EXPECT_EQ(first.q_start, whole.q_start);
  EXPECT_FALSE(first.start_from_command_line);
  EXPECT_EQ(last.q_start, first.segments.back().knots.back().q);
  EXPECT_EQ(last.u_start, first.segments.back().knots.back().u);
  EXPECT_TRUE(last.start_from_command_line);
  EXPECT_EQ(last.status, whole.status);
  EXPECT_EQ(first.status, core::Status::MaxIterations);
  EXPECT_GT(first.error.position, whole.error.position + whole.tol_position) << "the push moves the box: the test would say nothing";
  EXPECT_EQ(last.sha256, content_sha256(last));
  EXPECT_EQ(parse_plan(to_text(last), "plan.json").sha256, last.sha256);
}

/// Of an honest plan the checker finds nothing in its parts but that they end early, or begin under load.
TEST(PlanSlice, Parts_AreAsHonestAsThePlan) {
  const ScriptedPlan plan = push_box();  // it comes near, pushes, leaves
  const std::size_t count = plan.file.segments.size();
  const std::set<std::string> expected{"start", "goal_position", "goal_angle", "status"};
  for (const auto& [first, last] : {std::pair{std::size_t{0}, count - 1}, std::pair{std::size_t{1}, count}, std::pair{count - 1, count}}) {
    Task task = plan.task;
    const PlanFile part = slice(task, plan.file, first, last);
    CheckReport report;
    ASSERT_EQ(check_plan(task, part, {}, {}, report), core::Status::Solved);
    for (const auto& item : report.items) EXPECT_TRUE(item.pass || expected.contains(item.name)) << item.name << " " << item.where;
  }
}

TEST(PlanSlice, EditedPlan_StaysEdited) {
  ScriptedPlan plan = push_box();
  plan.file.segments.front().knots.front().u[0] += 1e-3;
  const PlanFile part = slice(plan.task, plan.file, 0, 1);
  EXPECT_NE(part.sha256, content_sha256(part));
}

TEST(PlanSlice, NoSegment_IsRefused) {
  const ScriptedPlan plan = push_box();  // it comes near, pushes, leaves
  const std::size_t count = plan.file.segments.size();
  for (const auto& [first, last] : {std::pair{std::size_t{1}, std::size_t{1}}, std::pair{std::size_t{0}, count + 1}}) {
    try {
      (void)slice(plan.task, plan.file, first, last);
      ADD_FAILURE() << "accepted";
    } catch (const core::InvalidInput& e) {
      EXPECT_NE(std::string(e.what()).find("segments: got ["), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace stiction::tasks
