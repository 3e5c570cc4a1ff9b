#include "stiction/tasks/check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/check_figures.hpp"
#include "support/paths.hpp"
#include "tasks/scripted_plan.hpp"

namespace stiction::tasks {
namespace {

CheckReport check(const Task& task, const PlanFile& plan) {
  CheckReport report;
  EXPECT_EQ(check_plan(task, plan, {}, {}, report), core::Status::Solved);
  return report;
}

std::string failures(const CheckReport& report) {
  std::string out;
  for (const auto& item : report.items) {
    if (!item.pass) out += item.name + " = " + std::to_string(item.value) + " > " + std::to_string(*item.limit) + " " + item.where + "\n";
  }
  return out;
}

class CheckTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    box_ = new ScriptedPlan(push_box());
    ball_ = new ScriptedPlan(squeeze_ball());
  }
  static void TearDownTestSuite() {
    delete box_;
    delete ball_;
  }
  static inline ScriptedPlan* box_ = nullptr;
  static inline ScriptedPlan* ball_ = nullptr;
};

TEST_F(CheckTest, HonestPlans_Pass) {
  for (const ScriptedPlan* plan : {box_, ball_}) {
    const CheckReport report = check(plan->task, plan->file);
    EXPECT_TRUE(report.pass) << failures(report);
    EXPECT_GT(report.knots, 5);
    EXPECT_EQ(report.steps, 3 * report.knots);  // two half steps and one full one
    long contacts = 0;
    for (const auto& segment : plan->file.segments) {
      for (const auto& knot : segment.knots) contacts += static_cast<long>(knot.contacts.size());
    }
    EXPECT_GT(contacts, 5) << "no contact: the test would say nothing";
  }
}

/// A cube that falls onto a hand turns farther in a step than the linear gap of its contact tells. Nothing was planned there yet.
TEST_F(CheckTest, WhatFallsToRestAtTheStart_MayFeelAForceAcrossAGap) {
  Task task = load_task("allegro_cube");
  Eigen::VectorXd& q = task.problem.q_start;
  q[2] += 0.02;
  q.segment<4>(3) = (Eigen::Quaterniond(q[6], q[3], q[4], q[5]) * Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 1, 0).normalized())).coeffs();
  const Eigen::VectorXd u = q.tail(16);
  ScriptedPlan plan = run_script(std::move(task), {u, u, u});
  const auto gap = [&] {
    const CheckReport report = check(plan.task, plan.file);
    return std::ranges::find(report.items, "force_gap", &CheckItem::name)->value;
  };
  EXPECT_GT(gap(), 1);
  plan.file.segments.front().kind = planning::SegmentKind::Settle;
  EXPECT_LE(gap(), 1);
}

/// The same motion called a regrasp: the hand goes elsewhere and drags the box along, or leaves it and never comes near anything again.
TEST_F(CheckTest, RegraspInContact_IsFoundAndOneInTheAirIsNot) {
  PlanFile plan = box_->file;
  ASSERT_EQ(check(box_->task, plan).at("regrasp_contact").value, 0);
  for (auto& segment : plan.segments) segment.kind = planning::SegmentKind::Contact;
  plan.segments[1].kind = planning::SegmentKind::Regrasp;  // the push by 0.3 m
  const CheckReport dragged = check(box_->task, plan);
  EXPECT_FALSE(dragged.pass);
  EXPECT_GT(dragged.at("regrasp_contact").value, 0.1) << "it travels 0.3 m, most of it in contact";
  plan.segments[1].kind = planning::SegmentKind::Contact;
  plan.segments[2].kind = planning::SegmentKind::Regrasp;  // away from the box
  EXPECT_EQ(check(box_->task, plan).at("regrasp_contact").value, 0);
}

/// A hand goes from one place to another beside a thing on the ground: a box stays there by itself, a ball is free to roll, and not where walls are about it.
TEST_F(CheckTest, RegraspThatLeavesABallFreeToRoll_IsLoose) {
  const auto loose = [](const std::string& shape, const std::string& fixed) {
    const Task task = parse_task(
        "scene:\n  robots: [{name: hand, urdf: planar_pusher.urdf, stiffness: 100}]\n"
        "  fixed:\n  - {name: ground, shapes: [{half_space: {}}]}\n" +
            fixed + "  objects: [{name: thing, joint: free, mass: 0.5, shapes: [" + shape +
            "]}]\n"
            "start: {joints: [-0.5, 0.5], objects: {thing: {position: [0, 0, 0.05]}}}\n"
            "goal: {objects: {thing: {position: [0, 0.5, 0.05]}}}\ntolerance: {position: 0.01, angle: 0.1}\n",
        test::source_dir() / "models");
    const Eigen::Vector2d u = task.problem.q_start.tail(2);
    const PlanFile plan = run_script(task, {u, u + Eigen::Vector2d(0, 0.3)}).file;
    PlanFile regrasp = plan;
    regrasp.segments.back().kind = planning::SegmentKind::Regrasp;
    const CheckReport report = check(task, regrasp);
    EXPECT_EQ(report.at("regrasp_contact").value, 0);
    EXPECT_TRUE(report.at("unstable_releases").pass) << "told, not judged";
    EXPECT_EQ(check(task, plan).at("unstable_releases").value, 0) << "no regrasp";
    return report.at("unstable_releases").value;
  };
  const std::string walls = R"(  - {name: west, pose: {position: [-0.06, 0, 0.05]}, shapes: [{box: {size: [0.02, 0.2, 0.1]}}]}
  - {name: east, pose: {position: [0.06, 0, 0.05]}, shapes: [{box: {size: [0.02, 0.2, 0.1]}}]}
  - {name: south, pose: {position: [0, -0.06, 0.05]}, shapes: [{box: {size: [0.1, 0.02, 0.1]}}]}
  - {name: north, pose: {position: [0, 0.06, 0.05]}, shapes: [{box: {size: [0.1, 0.02, 0.1]}}]}
)";
  EXPECT_EQ(loose("{box: {size: [0.1, 0.1, 0.1]}}", ""), 0);
  EXPECT_EQ(loose("{sphere: {radius: 0.05}}", ""), 1);
  EXPECT_EQ(loose("{sphere: {radius: 0.05}}", walls), 0);
}

/// Judged by what the box bears, from the replay and from what the file says.
TEST_F(CheckTest, BoxThatBearsLessThanThePush_IsFound) {
  const auto with_limit = [&](double most) {
    Task task = box_->task;
    world::Scene scene = task.model->scene();
    for (auto& geometry : scene.objects[0].geometries) geometry.max_force = most;
    task.model = world::Model::make(scene);
    return task;
  };
  EXPECT_EQ(check(box_->task, box_->file).at("max_force").value, 0);
  const double force = check(with_limit(1), box_->file).at("max_force").value;
  EXPECT_GT(force, 0.1);
  EXPECT_TRUE(check(with_limit(1.01 * force), box_->file).at("max_force").pass);
  const CheckReport broken = check(with_limit(0.99 * force), box_->file);
  EXPECT_FALSE(broken.at("max_force").pass);
  EXPECT_FALSE(broken.pass);
  EXPECT_NE(broken.at("max_force").where.find("box"), std::string::npos) << broken.at("max_force").where;
  PlanFile forged = box_->file;
  for (auto& segment : forged.segments) {
    for (auto& knot : segment.knots) {
      for (auto& contact : knot.contacts) contact.force_W *= 3;
    }
  }
  EXPECT_GT(check(with_limit(1), forged).at("max_force").value, 2.5 * force);
}

/// A stone of a hundred tons that nothing touches hides no force on the box.
TEST_F(CheckTest, ForcesThatAreLookedAt_AreMeasuredByTheirOwnPair) {
  const auto threshold = [](const char* more) {
    const Task task = parse_task(std::string(R"(
scene:
  robots: [{name: hand, urdf: planar_pusher.urdf, stiffness: 100}]
  fixed: [{name: ground, shapes: [{half_space: {}}]}]
  objects:
  - {name: box, joint: planar_yz, mass: 0.5, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}
)") + (*more ? "  - {name: stone, joint: planar_yz, mass: 1.0e5, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}\n" : "") +
                                     "start: {joints: [-1, 1], objects: {box: {coordinates: [0, 0.05, 0]}" + more + "}}\n" +
                                     "goal: {objects: {box: {coordinates: [1, 0.05, 0]}}}\ntolerance: {position: 0.01, angle: 0.1}\n"
                                     "planner: {sample_box: {box: {lower: [-1, 0, -1], upper: [1, 1, 1]}}}\n",
                                 test::source_dir() / "models");
    planning::PlanResult result;
    result.plan.q_start = task.problem.q_start;
    result.plan.u_start = task.problem.q_start.tail(2);
    result.plan.goal = task.problem.goal;
    return check(task, make_plan_file(task, task.options, result, "plan.json")).threshold_N;
  };
  EXPECT_NEAR(threshold(""), 1e-3 * 0.5 * 9.81, 1e-12);
  EXPECT_EQ(threshold(", stone: {coordinates: [50, 0.05, 0]}"), threshold(""));
}

TEST_F(CheckTest, StoredAndReadBack_Passes) {
  const PlanFile again = parse_plan(to_text(ball_->file), "plan.json");
  const CheckReport report = check(ball_->task, again);
  EXPECT_TRUE(report.pass) << failures(report);
}

struct Forgery {
  const char* what;
  const char* caught_by;
  std::function<void(PlanFile&)> apply;
};

StoredKnot& middle(PlanFile& plan) {
  auto& knots = plan.segments[1].knots;
  return knots[knots.size() / 2];
}

TEST_F(CheckTest, Forgeries_AreCaughtByTheRightCheck) {
  const std::vector<Forgery> forgeries = {
      {"goal moved", "goal_position", [](PlanFile& p) { p.goal_pose[1] += 0.1; }},
      {"goal moved", "goal", [](PlanFile& p) { p.goal_pose[1] += 0.001; }},
      {"goal turned", "goal_angle",
       [](PlanFile& p) { p.goal_pose[3] = 0.6, p.goal_pose[4] = 0.8, p.goal_pose[5] = 0, p.goal_pose[6] = 0; }},
      {"goal widened", "goal",
       [](PlanFile& p) {
         const double infinity = std::numeric_limits<double>::infinity();
         p.region = planning::GoalRegion{Eigen::Vector3d::Constant(-infinity), Eigen::Vector3d::Constant(infinity)};
       }},
      {"wider tolerance", "goal", [](PlanFile& p) { p.tol_position *= 100; }},
      {"error polished", "error", [](PlanFile& p) { p.error.position += 0.005; }},
      {"command changed", "stored_position", [](PlanFile& p) { middle(p).u[1] -= 0.05; }},
      {"command jump", "command_step", [](PlanFile& p) { middle(p).u[1] -= 0.05; }},
      {"state changed", "stored_position", [](PlanFile& p) { middle(p).q[1] += 2e-3; }},
      {"angle changed", "stored_angle", [](PlanFile& p) { middle(p).q[2] += 5e-3; }},
      {"penetrating state", "penetration", [](PlanFile& p) { middle(p).q[1] -= 0.05; }},
      {"knot removed", "stored_position",
       [](PlanFile& p) { p.segments[1].knots.erase(p.segments[1].knots.end() - 6, p.segments[1].knots.end() - 1); }},
      {"end cut off", "goal_position", [](PlanFile& p) { p.segments.resize(1); }},
      {"force scaled", "stored_force", [](PlanFile& p) { middle(p).contacts[0].force_W *= 2; }},
      {"force removed", "stored_force", [](PlanFile& p) { middle(p).contacts.clear(); }},
      {"force out of its cone", "stored_cone",
       [](PlanFile& p) { middle(p).contacts[0].force_W += 50 * middle(p).contacts[0].normal_W.unitOrthogonal(); }},
      {"moment of a contact that is a point", "stored_cone", [](PlanFile& p) { middle(p).contacts[0].moment = 0.1; }},
      {"pulling force", "stored_cone", [](PlanFile& p) { middle(p).contacts[0].force_W *= -1; }},
      {"other friction", "dynamics", [](PlanFile& p) { p.step.friction_scale = 3; }},
      {"other time step", "dynamics", [](PlanFile& p) { p.step.h *= 2; }},
      {"other regularisation", "dynamics", [](PlanFile& p) { p.step.regularisation = dynamics::FixedEpsilon{7.0}; }},
      {"longer sub-steps", "dynamics", [](PlanFile& p) { p.substep->joint_travel *= 10; }},
      {"motors without limits", "dynamics", [](PlanFile& p) { p.step.effort_limits = false; }},
      {"no sub-steps", "dynamics", [](PlanFile& p) { p.substep.reset(); }},
      {"start moved", "start", [](PlanFile& p) { p.q_start[0] += 1e-3; }},
      {"start command moved", "start", [](PlanFile& p) { p.u_start[0] += 1e-3; }},
      {"settings of the search", "settings", [](PlanFile& p) { p.options.replace(p.options.find("\"goal_bias\":0.") + 14, 0, "1"); }},
      {"friction of a contact", "stored_cone", [](PlanFile& p) { middle(p).contacts[0].friction = 100; }},
      {"gap of a contact", "stored_contact", [](PlanFile& p) { middle(p).contacts[0].gap = -0.5; }},
      {"point of a contact", "stored_contact", [](PlanFile& p) { middle(p).contacts[0].point_W[1] += 1e-4; }},
      {"not solved", "status", [](PlanFile& p) { p.status = core::Status::MaxIterations; }},
      {"statistics", "edited", [](PlanFile& p) { p.failed_steps += 77; }},
      {"name of the task", "edited", [](PlanFile& p) { p.task_name += "x"; }},
      {"contacts looked for farther away", "dynamics", [](PlanFile& p) { p.step.contact_margin = 0.5; }},
      {"page data moved", "display_poses", [](PlanFile& p) { middle(p).bodies[0][2] += 1e-3; }},
  };
  for (const auto& forgery : forgeries) {
    SCOPED_TRACE(std::string(forgery.what) + " -> " + forgery.caught_by);
    PlanFile forged = box_->file;
    ASSERT_FALSE(middle(forged).contacts.empty());
    forgery.apply(forged);
    const CheckReport report = check(box_->task, forged);
    EXPECT_FALSE(report.pass);
    EXPECT_FALSE(report.at(forgery.caught_by).pass) << failures(report);
  }
}

TEST_F(CheckTest, BadQuaternion_IsCaughtAndSurvived) {
  for (const double scale : {1.001, 0.0}) {
    PlanFile forged = ball_->file;
    middle(forged).q.segment(3, 4) *= scale;
    const CheckReport report = check(ball_->task, forged);
    EXPECT_FALSE(report.at("quaternion_norm").pass);
  }
}

/// What the file says is simulated bit by bit: a quaternion that is off by rounding is not made another one, from which a contact may be found elsewhere.
TEST_F(CheckTest, StateWithinRounding_IsSimulatedAsItIsStored) {
  const CheckReport report = check(ball_->task, ball_->file);
  EXPECT_EQ(report.at("stored_position").value, 0);
  EXPECT_EQ(report.at("stored_angle").value, 0);
  const world::Model& model = *ball_->task.model;
  Eigen::VectorXd q = ball_->file.q_start;
  q.segment(3, 4) = Eigen::Vector4d(0.5, 0.5, 0.5, 0.5 * (1 + 1e-14));
  ASSERT_NE(q.segment(3, 4).normalized()[0], 0.5) << "rounding would change it";
  EXPECT_EQ(normalised(model, q), q);
  q.segment(3, 4) *= 1.001;
  EXPECT_NEAR(normalised(model, q).segment(3, 4).norm(), 1, 1e-15);
}

/// A search that runs out of time computes no forces any more: that is no fault of the forces.
TEST_F(CheckTest, UnsolvedPlanWithoutForces_FailsByItsStatusAlone) {
  PlanFile unsolved = box_->file;
  unsolved.status = core::Status::MaxIterations;
  for (auto& segment : unsolved.segments) {
    for (auto& knot : segment.knots) knot.contacts.clear();
  }
  unsolved.sha256 = content_sha256(unsolved);
  const CheckReport report = check(box_->task, unsolved);
  EXPECT_FALSE(report.at("status").pass);
  EXPECT_TRUE(report.at("stored_force").pass) << failures(report);
  EXPECT_FALSE(report.at("stored_force").limit.has_value()) << "reported, not judged";
  for (const auto& item : report.items) EXPECT_TRUE(item.pass || item.name == "status") << failures(report);
  unsolved.status = core::Status::Solved;
  EXPECT_FALSE(check(box_->task, unsolved).at("stored_force").pass);
}

/// Largest K|u − q| of a stored knot over the effort, and its joint.
std::pair<double, std::string> largest_effort(const ScriptedPlan& plan, const world::Model& model) {
  std::pair<double, std::string> out{0, ""};
  for (const auto& segment : plan.file.segments) {
    for (const auto& knot : segment.knots) {
      for (int j = 0; j < model.n_a(); ++j) {
        const double share = model.stiffness()[j] * std::abs(knot.u[j] - knot.q[model.n_qu() + j]) / model.effort()[j];
        if (share > out.first) out = {share, plan.file.joints[static_cast<std::size_t>(j)]};
      }
    }
  }
  return out;
}

TEST_F(CheckTest, Efforts_AreReportedAndJudgedWhereThePlanBoundsThem) {
  const CheckReport plain = check(ball_->task, ball_->file);
  const auto [share, joint] = largest_effort(*ball_, *ball_->task.model);
  EXPECT_GT(share, 0.01);
  EXPECT_NEAR(plain.at("effort").value, share, 1e-12 * share);
  EXPECT_EQ(plain.at("effort").where.substr(0, joint.size()), joint);
  ASSERT_TRUE(plain.at("effort").limit && plain.at("effort").pass);
  EXPECT_GT(*plain.at("effort").limit, 1);
  EXPECT_LT(*plain.at("effort").limit, 1.05);
  PlanFile forged = ball_->file;
  const world::Model& model = *ball_->task.model;
  middle(forged).u[1] = middle(forged).q.tail(16)[1] + 1.1 * model.effort()[1] / model.stiffness()[1];
  EXPECT_FALSE(check(ball_->task, forged).at("effort").pass);
  PlanFile unbounded = ball_->file;
  unbounded.step.effort_limits = false;
  const CheckReport report = check(ball_->task, unbounded);
  EXPECT_FALSE(report.at("effort").limit.has_value());
  EXPECT_FALSE(report.at("dynamics").pass);
}

TEST_F(CheckTest, CommandBeyondALimit_IsCaught) {
  PlanFile forged = ball_->file;
  middle(forged).u[1] = ball_->task.model->upper()[1] + 1e-3;
  const CheckReport report = check(ball_->task, forged);
  EXPECT_FALSE(report.at("command_limits").pass);
  forged = ball_->file;
  middle(forged).q.tail(16)[1] = ball_->task.model->upper()[1] + 1e-3;
  EXPECT_FALSE(check(ball_->task, forged).at("joint_limits").pass);
}

TEST_F(CheckTest, EmptyPlan_FailsAtTheGoal) {
  PlanFile empty = box_->file;
  empty.segments.clear();
  const CheckReport report = check(box_->task, empty);
  EXPECT_FALSE(report.pass);
  EXPECT_FALSE(report.at("goal_position").pass);
}

/// The lever is where the plan leaves it, one turn less than its goal: the pose is the same.
TEST(CheckHinge, PlanOneTurnShort_FailsAtTheGoal) {
  Task task = parse_task(R"(
scene:
  gravity: [0, 0, 0]
  robots: [{name: hand, urdf: planar_pusher.urdf, stiffness: 100}]
  objects: [{name: lever, joint: hinge, axis: [1, 0, 0], mass: 1, limits: [-1, 7], shapes: [{box: {size: [0.2, 1, 0.1]}}]}]
start: {objects: {lever: {coordinates: [0]}}, joints: [0.3, -0.3]}
goal: {objects: {lever: {coordinates: [6.2831853]}}}
tolerance: {position: 0.02, angle: 0.1}
planner: {sample_box: {lever: {lower: [-1], upper: [7]}}}
)",
                         test::source_dir() / "models");
  const planning::Goal& goal = task.problem.goal;
  Eigen::VectorXd q = task.problem.q_start;
  EXPECT_NEAR(planning::goal_error(*task.model, q, goal).angle, 6.2831853, 1e-12);
  q[0] = 6.2331853;
  EXPECT_NEAR(planning::goal_error(*task.model, q, goal).angle, 0.05, 1e-12);
  EXPECT_TRUE(planning::goal_error(*task.model, q, goal).within(goal));
  planning::PlanResult result;
  result.plan.q_start = task.problem.q_start;
  result.plan.u_start = task.problem.q_start.tail(2);
  result.plan.goal = task.problem.goal;
  result.plan.step.h = task.options.step_options(*task.model).h;
  result.plan.step.regularisation = task.options.step_options(*task.model).regularisation;
  result.plan.error = planning::goal_error(*task.model, task.problem.q_start, task.problem.goal);
  EXPECT_NEAR(result.plan.error.angle, 6.2831853, 1e-12);
  const CheckReport report = check(task, parse_plan(to_text(make_plan_file(task, task.options, result, "plan.json")), "plan.json"));
  EXPECT_NEAR(report.at("goal_angle").value, 6.2831853, 1e-12);
  EXPECT_FALSE(report.at("goal_angle").pass);
  EXPECT_TRUE(report.at("goal").pass);
  EXPECT_TRUE(report.at("error").pass);

  set_goal(task, std::vector<double>{1.0});
  EXPECT_FALSE(goal.region) << "no other turn of 1 rad is near, or inside the limits: the pose tells it";
  set_goal(task, std::vector<double>{-0.5});
  EXPECT_TRUE(goal.region) << "5.78 is inside the limits and has the same pose";
  q[0] = 2 * std::numbers::pi - 0.5;
  EXPECT_NEAR(planning::goal_error(*task.model, q, goal).angle, 2 * std::numbers::pi, 1e-12);
}

/// An angle in a plane is a rotation.
TEST(CheckHinge, PlanarAngle_IsTheSameAfterATurn) {
  const Task task = load_task("planar_pushing");
  Eigen::VectorXd q = task.problem.q_start;
  const double before = planning::goal_error(*task.model, q, task.problem.goal).angle;
  q[2] += 2 * std::numbers::pi;
  EXPECT_NEAR(planning::goal_error(*task.model, q, task.problem.goal).angle, before, 1e-12);
}

TEST_F(CheckTest, Cancel_Stops) {
  std::atomic<bool> cancel{true};
  core::RunControl control;
  control.cancel = &cancel;
  CheckReport report;
  EXPECT_EQ(check_plan(box_->task, box_->file, {}, control, report), core::Status::Cancelled);
  EXPECT_FALSE(report.pass);
  EXPECT_THROW((void)report.at("nothing"), core::InvalidInput);
}

/// The hand pushes the stick by some 0.1 m in a task of the box alone.
TEST(CheckBystanders, OneThatGoesTooFar_IsFound) {
  const auto pushed = [](const std::string& may_move) {
    Task task = parse_task(
        "base: stick.yaml\nstart: {objects: {stick: {coordinates: [0, 0.2, 0]}}}\ngoal: {objects: {box: {coordinates: [0, 1.2, "
        "~]}}}\nbystanders: {may_move: " +
            may_move + "}\n",
        test::source_dir() / "tests/tasks/data");
    return run_script(std::move(task), {Eigen::Vector2d(0, -0.2)});
  };
  const ScriptedPlan wide = pushed("0.5"), narrow = pushed("0.05");
  const PlanFile read = parse_plan(to_text(wide.file), "plan.json");
  EXPECT_EQ(to_text(read), to_text(wide.file));
  ASSERT_TRUE(read.bystanders);
  EXPECT_EQ(read.bystanders->objects, std::vector<int>{1});
  EXPECT_EQ(to_plan(*wide.task.model, read).goal.bystanders->may_move, 0.5);

  const CheckReport good = check(wide.task, read), bad = check(narrow.task, narrow.file);
  const double moved = wide.result.plan.segments.back().knots.back().q[4] - wide.task.problem.q_start[4];
  EXPECT_GT(moved, 0.05) << "the test would say nothing";
  EXPECT_NEAR(good.at("bystander_move").value, moved, 1e-3);  // at half steps
  EXPECT_TRUE(good.pass) << failures(good);
  EXPECT_FALSE(bad.at("bystander_move").pass);
  EXPECT_FALSE(bad.pass);
  EXPECT_FALSE(check(narrow.task, wide.file).at("goal").pass) << "the limits of another task";
}

}  // namespace
}  // namespace stiction::tasks
