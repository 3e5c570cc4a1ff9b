#include <gtest/gtest.h>

#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/check.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/unplanned.hpp"
#include "tasks/scripted_plan.hpp"

namespace stiction::tasks {
namespace {

/// The hand of planar_pushing against the box of 1 m: it stands 0.1 m before the box of the start and pushes it by what it goes farther than that.
TEST(Commanded, PushAlongTheMiddle_MovesTheBoxByTheRest_AndIsAccepted) {
  Task task = load_task("planar_pushing", default_data_dirs());
  Eigen::VectorXd start = task.problem.q_start;
  start << 0, 0.5, 0, 0, -0.2;
  set_start(task, start);
  Eigen::MatrixXd commands(2, 1);
  commands << 0, 0;
  const planning::PlanResult result = make_commanded(task, commands);
  ASSERT_EQ(result.status, core::Status::MaxIterations) << "the goal is elsewhere";
  const Eigen::VectorXd& q = result.plan.segments.back().knots.back().q;
  EXPECT_GT(q[1], 0.55) << "the box was pushed";
  EXPECT_NEAR(q[1] - 0.5 - 0.1, q[4], 1e-4) << "box and ball of 0.1 m touch";
  EXPECT_NEAR(q[0], 0, 1e-6);
  EXPECT_EQ(result.plan.segments.back().knots.back().contacts.size(), 1U);
  const PlanFile file = make_plan_file(task, task.options, result, "plan.json");
  CheckReport report;
  ASSERT_EQ(check_plan(task, parse_plan(to_text(file), "plan.json"), {}, {}, report), core::Status::Solved);
  for (const auto& item : report.items)
    EXPECT_TRUE(item.pass || item.name.starts_with("goal") || item.name == "status") << item.name << " " << item.where;
}

TEST(Commanded, WithoutCommands_StaysAtTheStart) {
  const Task task = load_task("planar_pushing", default_data_dirs());
  const planning::PlanResult result = make_commanded(task, Eigen::MatrixXd(2, 0));
  ASSERT_EQ(result.plan.segments.back().knots.size(), 1U);
  EXPECT_EQ(result.plan.segments.back().knots[0].q, task.problem.q_start);
}

TEST(Commanded, BadInput_IsNamed) {
  const Task task = load_task("planar_pushing", default_data_dirs());
  EXPECT_THROW(make_commanded(task, Eigen::MatrixXd::Zero(3, 1)), core::InvalidInput);
  EXPECT_THROW(make_commanded(task, Eigen::MatrixXd::Constant(2, 1, std::numeric_limits<double>::quiet_NaN())), core::InvalidInput);
}

}  // namespace
}  // namespace stiction::tasks
