#include "stiction/planning/refine.hpp"

#include <atomic>
#include <limits>

#include "planning/systems.hpp"
#include "stiction/contact/contact.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/regrasp.hpp"
#include "support/message_of.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;
using Eigen::Vector2d;
using Eigen::VectorXd;
using stiction::test::message_of;

/// planar_pushing, with a plan made by hand.
struct Pushing {
  Pushing() {
    plan.q_start = (VectorXd(5) << 0, 0.6, 0, 0, -0.05).finished();
    plan.u_start = plan.q_start.tail(2);
    plan.substep = {.joint_angle = 0.03, .joint_travel = 0.03, .slide = 2e-3, .max_substeps = 400};
    q = plan.q_start;
    u = plan.u_start;
  }

  void go(SegmentKind kind, const std::vector<Vector2d>& corners) {
    dynamics::StepWorkspace work(model);
    Segment& segment = plan.segments.emplace_back(Segment{kind, {}, false});
    for (const auto& corner : corners) {
      dynamics::RolloutResult r;
      ASSERT_EQ(dynamics::rollout(*model, q, u, corner, plan.step, plan.substep, work, r), Status::Solved);
      segment.knots.insert(segment.knots.end(), r.knots.begin(), r.knots.end());
      q = r.knots.back().q;
      u = corner;
    }
  }

  void set_goal() {
    plan.goal.X_WG = world::object_pose(*model, q, 0);
    plan.goal.tol_position = 0.02;
    plan.error = {0, 0};
  }

  Status run(RefineResult& out) { return refine(model, plan, options, refine_options, control, out); }

  std::shared_ptr<const world::Model> model = load_model("planar_pushing");
  PlannerOptions options;
  RefineOptions refine_options;
  core::RunControl control;
  Plan plan;
  VectorXd q, u;
};

/// Up, away, a push into the air, back, up again.
Pushing push_with_detour() {
  Pushing p;
  p.go(SegmentKind::Contact, {{0, 0.1}});
  p.go(SegmentKind::Regrasp, {{0, 0.03}, {-0.8, 0.0}, {-0.8, 0.3}});
  p.go(SegmentKind::Contact, {{-0.9, 0.4}});
  p.go(SegmentKind::Regrasp, {{-0.8, 0.3}, {-0.8, 0.0}, {0.0, 0.0}, {0, 0.085}});
  p.go(SegmentKind::Contact, {{0, 0.2}});
  p.set_goal();
  return p;
}

/// Every knot is one exact sub-step from the knot before it.
void expect_consistent(const world::Model& model, const std::shared_ptr<const world::Model>& shared, const Plan& plan) {
  dynamics::StepWorkspace work(shared);
  dynamics::StepResult r;
  dynamics::StepOptions options = plan.step;
  options.warm_start = false;
  VectorXd q = plan.q_start;
  for (const auto& segment : plan.segments) {
    for (const auto& knot : segment.knots) {
      ASSERT_EQ(dynamics::step(model, {q, knot.u}, options, work, r), Status::Solved);
      EXPECT_LT((r.q_next - knot.q).cwiseAbs().maxCoeff(), 1e-5);
      q = knot.q;
    }
  }
}

/// Smallest gap of any pair of the hand over the middle of a regrasp, between the first and the last moment `clearance` away from it all.
double least_gap(const world::Model& model, const Segment& segment, double clearance) {
  contact::GeometryWorkspace work(model);
  std::vector<int> pairs;
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) pairs.push_back(i);
  std::vector<double> gaps;
  for (const auto& knot : segment.knots) {
    world::calc_kinematics(model, knot.q, work.kinematics_work, work.kinematics);
    gaps.push_back(contact::calc_min_distance(model, work.kinematics, pairs, -std::numeric_limits<double>::infinity(), work.contact_work));
  }
  std::size_t first = 0, last = gaps.size();
  while (first < last && gaps[first] < clearance) ++first;
  while (last > first && gaps[last - 1] < clearance) --last;
  EXPECT_LT(first, last) << "the hand never leaves";
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = first; k < last; ++k) least = std::min(least, gaps[k]);
  return least;
}

/// Largest move of a command in one step.
double longest_command(const Plan& plan, SegmentKind kind) {
  double longest = 0;
  VectorXd u = plan.u_start;
  for (const auto& segment : plan.segments) {
    for (const auto& knot : segment.knots) {
      if (segment.kind == kind) longest = std::max(longest, (knot.u - u).cwiseAbs().maxCoeff());
      u = knot.u;
    }
  }
  return longest;
}

TEST(Refine, PushIntoTheAir_IsDroppedAndTheRegraspsAroundItBecomeOne) {
  Pushing p = push_with_detour();
  RefineResult r;
  ASSERT_EQ(p.run(r), Status::Solved);
  EXPECT_EQ(r.variant, "refined");
  EXPECT_EQ(r.pushes_before, 3);
  EXPECT_EQ(r.pushes, 2);
  EXPECT_EQ(r.regrasps_before, 2);
  EXPECT_LE(r.regrasps, 1) << "the hand is where it was: it may not even have to let go";
  EXPECT_EQ(r.plan.step.h, 0.02);
  EXPECT_LT(r.knots, 5 * r.knots_before) << "every step of the plan becomes five";
  EXPECT_TRUE(r.plan.error.within(p.plan.goal));
  EXPECT_TRUE(r.fine_error.within(p.plan.goal));
  expect_consistent(*p.model, p.model, r.plan);
  const auto& last = r.plan.segments.back().knots;
  ASSERT_GT(last.size(), 1u);
  EXPECT_LT((last.back().q - last[last.size() - 2].q).cwiseAbs().maxCoeff(), 1e-3) << "the last push ends at rest";
}

TEST(Refine, Regrasp_KeepsTheLargestClearanceThereIsAPathFor) {
  Pushing p;
  p.go(SegmentKind::Contact, {{0, 0.1}});
  p.go(SegmentKind::Regrasp, {{0, 0.05}, {-0.65, 0.05}, {-0.65, 0.69}, {-0.605, 0.69}});  // 5 mm beside the box
  p.go(SegmentKind::Contact, {{-0.57, 0.69}});
  p.set_goal();
  p.refine_options.clearances = {0.05, 0.02};
  RefineResult r;
  ASSERT_EQ(p.run(r), Status::Solved) << r.fine_error.position << " m, " << r.fine_error.angle << " rad";
  ASSERT_EQ(r.variant, "refined");
  EXPECT_EQ(r.reconnected, 1);
  EXPECT_EQ(r.least_clearance, 0.05);
  const auto regrasp =
      std::find_if(r.plan.segments.begin(), r.plan.segments.end(), [](const auto& s) { return s.kind == SegmentKind::Regrasp; });
  ASSERT_NE(regrasp, r.plan.segments.end());
  EXPECT_GT(least_gap(*p.model, *regrasp, 0.045), 0.04);
  expect_consistent(*p.model, p.model, r.plan);
}

TEST(Refine, MotionlessTail_IsCut) {
  Pushing p;
  p.go(SegmentKind::Contact, {{0, 0.1}});
  p.go(SegmentKind::Contact, {{0, 0.02}});  // away from the box
  p.set_goal();
  RefineResult r;
  ASSERT_EQ(p.run(r), Status::Solved);
  EXPECT_EQ(r.variant, "refined");
  ASSERT_EQ(r.plan.segments.size(), 1u);
  EXPECT_TRUE(r.plan.error.within(p.plan.goal));
}

TEST(Refine, TimeStep_CutsEveryStepOfThePlan) {
  for (const double h : {0.1, 0.05, 0.03}) {  // 0.03 does not divide 0.1
    Pushing p = push_with_detour();
    p.refine_options.h = h;
    RefineResult r;
    ASSERT_EQ(p.run(r), Status::Solved);
    EXPECT_LE(r.plan.step.h, h + 1e-12);
    EXPECT_NEAR(std::round(0.1 / r.plan.step.h), 0.1 / r.plan.step.h, 1e-9);
    const double cut = r.plan.step.h / 0.1;
    EXPECT_NEAR(r.plan.substep.slide, cut * p.plan.substep.slide, 1e-12);
    EXPECT_EQ(r.plan.substep.joint_travel, p.plan.substep.joint_travel);
    EXPECT_LE(longest_command(r.plan, SegmentKind::Contact), cut * p.plan.substep.joint_travel + 1e-12);
    EXPECT_LE(longest_command(r.plan, SegmentKind::Regrasp), p.plan.substep.joint_travel + 1e-12);
  }
}

TEST(Refine, RegraspThatTouchesNothing_GoesAsFarInAStepAsThePlan) {
  Pushing p;
  p.go(SegmentKind::Contact, {{0, 0.1}});
  p.go(SegmentKind::Regrasp, {{0, 0.05}, {-0.65, 0.05}, {-0.65, 0.69}, {-0.605, 0.69}});
  p.go(SegmentKind::Contact, {{-0.57, 0.69}});
  p.set_goal();
  RefineResult r;
  ASSERT_EQ(p.run(r), Status::Solved);
  ASSERT_EQ(r.reconnected, 1);
  EXPECT_LT(r.plan.step.h, 0.021);
  EXPECT_GT(longest_command(r.plan, SegmentKind::Regrasp), 0.9 * p.plan.substep.joint_travel);
  EXPECT_LE(longest_command(r.plan, SegmentKind::Contact), 0.2 * p.plan.substep.joint_travel + 1e-12);
}

/// The planner's own plans: the goal is kept, joint limits hold, every state follows from the one before it.
TEST(Refine, PlannedPath_StaysAPlan) {
  PlanningProblem problem = hand_problem();
  PlannerOptions options = hand_options();
  options.seed = 3;
  PlanResult planned;
  ASSERT_EQ(plan(problem, options, {}, planned), Status::Solved);
  RefineResult r, again;
  ASSERT_EQ(refine(problem.model, planned.plan, options, {}, {}, r), Status::Solved);
  EXPECT_TRUE(goal_error(*problem.model, r.plan.segments.back().knots.back().q, problem.goal).within(problem.goal));
  EXPECT_LE(r.regrasps, r.regrasps_before);
  expect_consistent(*problem.model, problem.model, r.plan);
  for (const auto& segment : r.plan.segments) {
    for (const auto& knot : segment.knots) {
      constexpr double kRounding = 1e-12;  // of commands between two at a limit
      EXPECT_GE((knot.u - problem.model->lower()).minCoeff(), -kRounding);
      EXPECT_GE((problem.model->upper() - knot.u).minCoeff(), -kRounding);
    }
  }
  for (options.threads = 1; options.threads <= 3; ++options.threads) {
    ASSERT_EQ(refine(problem.model, planned.plan, options, {}, {}, again), Status::Solved);
    EXPECT_EQ(r.variant, again.variant);
    EXPECT_EQ(r.plan.segments.back().knots.back().q, again.plan.segments.back().knots.back().q) << "the same bits";
    EXPECT_EQ(r.steps, again.steps);
  }
}

/// The box is hit in the regrasp, and flees by some micrometres.
Pushing push_with_hit() {
  Pushing p;
  p.go(SegmentKind::Contact, {{0, 0.1}});
  p.go(SegmentKind::Regrasp, {{0, -0.1}, {0.15, -0.1}, {0.15, 0.13}, {0.15, -0.1}, {-0.1, -0.1}});
  p.go(SegmentKind::Contact, {{-0.1, 0.3}});
  p.set_goal();
  return p;
}

TEST(IsFreeOnItsWay, BoxThatIsHit_IsInTheWay) {
  const Pushing detour = push_with_detour(), hit = push_with_hit();
  contact::GeometryWorkspace work(*hit.model);
  const world::RobotChains chains(*hit.model);
  EXPECT_TRUE(is_free_on_its_way(*detour.model, chains, detour.plan.segments[1].knots, work));
  EXPECT_FALSE(is_free_on_its_way(*hit.model, chains, hit.plan.segments[1].knots, work));
}

/// In small steps, at the goal, and the same with any number of threads.
void expect_planned_anew(Pushing& p, RefineResult& r) {
  p.refine_options.extensions = 4000;
  ASSERT_EQ(p.run(r), Status::Solved);
  EXPECT_EQ(r.variant, "refined");
  EXPECT_EQ(r.plan.step.h, 0.02);
  EXPECT_TRUE(r.plan.error.within(p.plan.goal));
  EXPECT_TRUE(r.fine_error.within(p.plan.goal));
  expect_consistent(*p.model, p.model, r.plan);
  RefineResult again;
  for (p.options.threads = 1; p.options.threads <= 3; ++p.options.threads) {
    ASSERT_EQ(p.run(again), Status::Solved);
    EXPECT_EQ(r.plan.segments.back().knots.back().q, again.plan.segments.back().knots.back().q) << "the same bits";
    EXPECT_EQ(r.steps, again.steps);
  }
}

TEST(Refine, WhatSmallStepsLeave_IsPlannedAnew) {
  Pushing p = push_with_hit();
  p.refine_options.reconnect = false;  // nothing comes through the regrasp
  RefineResult r;
  ASSERT_NO_FATAL_FAILURE(expect_planned_anew(p, r));
  EXPECT_GE(r.rest_planned_anew, 1);
  p.refine_options.extensions = 0;
  ASSERT_EQ(p.run(r), Status::Solved);
  EXPECT_EQ(r.variant, "unchanged") << "without searches";
}

TEST(Refine, PlanThatMissesItsGoal_IsHandedBack) {
  Pushing p = push_with_detour();
  p.plan.goal.X_WG.p.z() += 0.1;
  RefineResult r;
  for (auto& segment : p.plan.segments) {
    for (auto& knot : segment.knots) knot.contacts.clear();  // as read from a file
  }
  EXPECT_EQ(p.run(r), Status::NumericalFailure);
  ASSERT_EQ(r.plan.segments.size(), p.plan.segments.size());
  EXPECT_EQ(r.plan.segments[0].knots.back().q, p.plan.segments[0].knots.back().q);
  EXPECT_FALSE(r.plan.segments[0].knots.back().contacts.empty()) << "with forces";
}

TEST(Refine, StoppedRuns_HandBackTheGivenPlan) {
  Pushing p = push_with_detour();
  const std::atomic<bool> cancel{true};
  p.control.cancel = &cancel;
  RefineResult r;
  EXPECT_EQ(p.run(r), Status::Cancelled);
  EXPECT_EQ(r.plan.segments.size(), p.plan.segments.size());
  p.control.cancel = nullptr;
  p.control.deadline = core::RunControl::Clock::now();
  EXPECT_EQ(p.run(r), Status::MaxIterations);
  EXPECT_EQ(r.knots, r.knots_before);
}

TEST(Refine, BadInput_NamesTheField) {
  Pushing p = push_with_detour();
  RefineResult r;
  const auto complaint = [&] { return message_of([&] { (void)p.run(r); }); };
  p.refine_options.clearances = {};
  EXPECT_NE(complaint().find("refine.clearances"), std::string::npos);
  p.refine_options.clearances = {-0.1};
  EXPECT_NE(complaint().find("refine.clearances"), std::string::npos);
  p.refine_options = {};
  p.refine_options.extensions = -1;
  EXPECT_NE(complaint().find("refine.extensions"), std::string::npos);
  p.refine_options = {};
  p.options.thesis.emplace();
  EXPECT_NE(complaint().find("options.thesis"), std::string::npos);
}

}  // namespace
}  // namespace stiction::planning::test
