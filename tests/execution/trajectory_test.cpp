#include "stiction/execution/open_loop/trajectory.hpp"

#include <numbers>

#include "planning/push_plan.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/world/read.hpp"
#include "support/message_of.hpp"

namespace stiction::execution::test {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;
using execution::SpeedLimits;
using planning::Plan;
using planning::Segment;
using planning::SegmentKind;
using namespace planning::test;
using stiction::test::message_of;

/// A plan for planar_pushing whose states are not simulated: only its commands count.
Plan commands_only(const std::vector<std::pair<SegmentKind, std::vector<Vector2d>>>& segments) {
  Plan plan;
  plan.q_start = (VectorXd(5) << 0, 0.6, 0, 0, -0.1).finished();
  plan.u_start = plan.q_start.tail(2);
  for (const auto& [kind, commands] : segments) {
    auto& segment = plan.segments.emplace_back(Segment{kind, {}});
    for (const auto& u : commands) {
      VectorXd q = plan.q_start;
      q.tail(2) = u;
      segment.knots.push_back({.u = u, .q = q, .contacts = {}});
    }
  }
  return plan;
}

TEST(Trajectory, OneJointMovesAtItsLimitAndNoneFaster) {
  const auto model = load_model("planar_pushing");
  const auto plan = commands_only({{SegmentKind::Contact, {{0.1, 0.0}, {0.12, 0.3}}}, {SegmentKind::Regrasp, {{1.0, 0.3}, {1.0, -0.4}}}});
  const SpeedLimits limits{.revolute = 1, .prismatic = 0.2, .regrasp_factor = 3, .landing_factor = 3, .pause = 0};
  const Trajectory t = make_trajectory(*model, plan, limits);
  ASSERT_EQ(t.pieces.size(), 2u);
  ASSERT_EQ(t.times.size(), 5);
  const double expected[] = {0.1 / 0.2, 0.3 / 0.2, 0.88 / 0.6, 0.7 / 0.6};
  for (Eigen::Index k = 0; k < 4; ++k) EXPECT_NEAR(t.times[k + 1] - t.times[k], expected[k], 1e-12) << k;
}

TEST(Trajectory, RandomPlans_SpeedOfEveryIntervalIsTheLimit) {
  const auto model = load_model("planar_hand");
  std::srand(3);
  Plan plan;
  plan.q_start = (VectorXd(7) << 0, 0.35, 0, -0.7, -0.7, 0.7, 0.7).finished();
  plan.u_start = plan.q_start.tail(4);
  for (int s = 0; s < 6; ++s) {
    auto& segment = plan.segments.emplace_back(Segment{s % 3 == 2 ? SegmentKind::Regrasp : SegmentKind::Contact, {}});
    for (int k = 0; k < 4; ++k) {
      const VectorXd u = plan.u_start + 0.1 * VectorXd::Random(4);
      VectorXd q = plan.q_start;
      q.tail(4) = u;
      segment.knots.push_back({.u = u, .q = q, .contacts = {}});
    }
  }
  const SpeedLimits limits{.revolute = 0.3, .prismatic = 1, .regrasp_factor = 2, .landing_factor = 2, .pause = 0.5};
  const Trajectory t = make_trajectory(*model, plan, limits);
  ASSERT_EQ(t.pieces.size(), 4u) << "edges that follow each other are one piece";
  for (const Piece& piece : t.pieces) {
    const double limit = piece.kind == SegmentKind::Regrasp ? 0.6 : 0.3;
    for (Eigen::Index k = piece.first_knot; k < piece.last_knot; ++k) {
      const double speed = ((t.u.col(k + 1) - t.u.col(k)) / (t.times[k + 1] - t.times[k])).cwiseAbs().maxCoeff();
      EXPECT_NEAR(speed, limit, 1e-9);
    }
  }
  for (std::size_t i = 1; i < t.pieces.size(); ++i)
    EXPECT_NEAR(t.times[t.pieces[i].first_knot] - t.times[t.pieces[i - 1].last_knot], 0.5, 1e-12) << "the pause";
}

/// From 0.25 to 2 times the speed within the first 0.5 s at the speed of pushes, and back: ∫ dr / f(r) by (E.8).
TEST(Trajectory, Regrasps_LeaveAndReachContactSlowly) {
  const auto model = load_model("planar_pushing");
  const auto plan = commands_only({{SegmentKind::Contact, {{0.0, 0.1}}}, {SegmentKind::Regrasp, {{0.1, 0.1}, {0.9, 0.3}, {1.0, 0.3}}}});
  const SpeedLimits limits{.revolute = 1, .prismatic = 0.1, .regrasp_factor = 2, .ramp = 0.25, .landing_factor = 0.25, .pause = 0};
  const Trajectory t = make_trajectory(*model, plan, limits);
  const Piece& piece = t.pieces.back();
  const double whole = 1.0 / 0.1, slow = 0.25 * 0.25 / 0.25, ramp = 0.25 * std::log(2 / 0.25), fast = (whole - 2 * 0.5) / 2;
  EXPECT_NEAR(t.times[piece.last_knot] - t.times[piece.first_knot], 2 * (slow + ramp) + fast, 0.03);
  double fastest = 0, last = 0, slowest = 1e9;
  for (Eigen::Index k = piece.first_knot; k < piece.last_knot; ++k) {
    last = (t.u(0, k + 1) - t.u(0, k)) / (t.times[k + 1] - t.times[k]) / 0.1;
    slowest = std::min(slowest, last);
    fastest = std::max(fastest, last);
    EXPECT_NEAR((t.q.col(k).tail(2) - t.u.col(k)).norm(), 0, 1e-9) << "states between those of the plan, as the commands";
  }
  EXPECT_NEAR(slowest, 0.25, 1e-9);
  EXPECT_NEAR(fastest, 2, 1e-9);
  EXPECT_NEAR(last, 0.25, 1e-9);
}

/// (E.9): a spring of which the command goes on while the joint stays, as in a grip that closes, and back.
TEST(Trajectory, Springs_AreStrainedAndLetGoSlowly) {
  const auto model = load_model("planar_pushing");
  auto plan = commands_only({{SegmentKind::Contact, {{0.1, -0.1}, {0.12, -0.1}, {0.1, -0.1}, {0.2, -0.1}}}});
  plan.segments[0].knots[1].q[3] = 0.1;
  // 0.02 m of a spring of 100 N/m are 2 N, the box weighs 5 kg
  SpeedLimits limits{.revolute = 1, .prismatic = 0.1, .load_time = 10, .pause = 0};
  const double load = 10 * 2 / (5 * 9.81);
  const auto intervals = [&] {
    const Trajectory t = make_trajectory(*model, plan, limits);
    return VectorXd(t.times.tail(4) - t.times.head(4));
  };
  EXPECT_TRUE(intervals().isApprox(Eigen::Vector4d(1, load, load, 1), 1e-12)) << intervals().transpose();
  limits.load_time = 0;
  EXPECT_TRUE(intervals().isApprox(Eigen::Vector4d(1, 0.2, 0.2, 1), 1e-12)) << intervals().transpose();
}

/// The ball of planar_hand_fixed_y turns on a carriage of a milligram, which nothing can touch.
TEST(Trajectory, WhatOnlyCarriesOthers_IsNotTheLightestObject) {
  const auto model = load_model("planar_hand_fixed_y");
  double ball = 0;
  for (const auto& object : model->scene().objects) ball = std::max(ball, object.mass);
  const VectorXd force = SpeedLimits{.load_time = 0.5}.of_springs(*model).cwiseProduct(model->stiffness()).cwiseQuotient(model->reach());
  EXPECT_TRUE(force.isApproxToConstant(9.81 * ball / 0.5, 1e-12)) << force.transpose();
}

/// A lock of a gram that its joint damps: 2 N·m·s/rad at 0.05 rad in half a second are 0.2 N·m, at L = 0.1 m 2 N, and its dry friction bears 1 N there.
TEST(Trajectory, WhatItsJointHolds_IsHeavierThanItsMass) {
  const auto force = [](const std::string& joint) {
    const auto model = world::Model::make(world::parse_scene(
        "robots: [{name: r, mjcf: \"<mujoco><worldbody><body><joint name='x' type='slide' axis='1 0 0' range='-1 1'/><geom size='.02' "
        "mass='1'/></body></worldbody>"
        "<actuator><position joint='x' kp='100'/></actuator></mujoco>\"}]\n"
        "objects: [{name: lock, axis: [0, 0, 1], mass: 0.001, pose: {position: [0, 1, 0]}, shapes: [{box: {size: [0.1, 0.1, 0.1]}}], " +
            joint + "}]\n",
        "."));
    return (SpeedLimits{.load_time = 0.5}.of_springs(*model).cwiseProduct(model->stiffness()).cwiseQuotient(model->reach()) * 0.5)[0];
  };
  EXPECT_NEAR(force("joint: hinge"), 9.81e-3, 1e-9);
  EXPECT_NEAR(force("joint: hinge, joint_damping: 2"), 2, 1e-9);
  EXPECT_NEAR(force("joint: hinge, joint_damping: 2, joint_friction: 0.1"), 3, 1e-9);
  EXPECT_NEAR(force("joint: slider, joint_damping: 20, joint_friction: 0.1"), 0.3, 1e-9);
}

TEST(Trajectory, KnotWithoutCommandIncrement_TakesNoTime) {
  const auto model = load_model("planar_pushing");
  const auto plan = commands_only({{SegmentKind::Contact, {{0.1, -0.1}, {0.1, -0.1}, {0.2, -0.1}}}});
  const Trajectory t = make_trajectory(*model, plan, {.revolute = 1, .prismatic = 0.1, .regrasp_factor = 1, .pause = 0});
  ASSERT_EQ(t.times.size(), 3);
  EXPECT_NEAR(t.duration(), 2.0, 1e-12);
}

TEST(Trajectory, Settling_IsLeftOut) {
  const auto model = load_model("planar_pushing");
  const auto plan = commands_only({{SegmentKind::Settle, {{0.0, -0.05}}}, {SegmentKind::Contact, {{0.1, -0.05}}}});
  const Trajectory t = make_trajectory(*model, plan, SpeedLimits{});
  ASSERT_EQ(t.pieces.size(), 1u);
  EXPECT_EQ(t.q(4, 0), -0.05) << "starts where the settling ended";
}

/// Every state is that of the knot of the plan that it names; within a regrasp, of the one that comes next.
TEST(Trajectory, KnotsNameThoseOfThePlan) {
  const auto model = load_model("planar_pushing");
  const auto plan = commands_only({{SegmentKind::Settle, {{0.0, -0.1}}},
                                   {SegmentKind::Contact, {{0.1, 0.0}, {0.1, 0.0}, {0.12, 0.3}}},
                                   {SegmentKind::Regrasp, {{1.0, 0.3}, {1.0, -0.4}}}});
  std::vector<VectorXd> states = {plan.q_start};
  for (const auto& segment : plan.segments) {
    for (const auto& knot : segment.knots) states.push_back(knot.q);
  }
  const Trajectory t = make_trajectory(*model, plan, SpeedLimits{});
  ASSERT_EQ(t.knots.size(), t.times.size());
  EXPECT_EQ(t.knots[0], 1) << "the end of settling";
  EXPECT_EQ(t.knots[t.knots.size() - 1], 6);
  const Eigen::Index regrasp = t.pieces.back().first_knot;
  for (Eigen::Index k = 0; k <= regrasp; ++k) {
    EXPECT_EQ(t.q.col(k), states[static_cast<std::size_t>(t.knots[k])]) << k;
    EXPECT_NE(t.knots[k], 2) << "the knot after it has the same command";
  }
  for (Eigen::Index k = regrasp + 1; k < t.knots.size(); ++k) {
    EXPECT_GE(t.knots[k], t.knots[k - 1]);
    const double reached = states[static_cast<std::size_t>(t.knots[k])][4];
    EXPECT_TRUE(t.q(4, k) == reached || t.q(4, k) > reached) << "on the way to " << reached;
    const bool ends = k + 1 == t.knots.size() || t.knots[k + 1] > t.knots[k];
    EXPECT_TRUE(!ends || t.q.col(k) == states[static_cast<std::size_t>(t.knots[k])]) << k;
  }
}

TEST(Trajectory, Interpolation_IsSphericalForOrientationsAndHeldOutside) {
  const auto model = load_model("allegro_ball");
  Trajectory t;
  t.times = Vector2d(0, 2);
  t.q.resize(23, 2);
  t.q.col(0).setZero(), t.q.col(1).setZero();
  t.q(6, 0) = 1;
  const double angle = std::numbers::pi / 2;
  t.q(5, 1) = std::sin(angle / 2), t.q(6, 1) = std::cos(angle / 2);
  t.q(0, 1) = 0.4, t.q(10, 1) = 1.0;
  VectorXd q(23);
  interpolate(*model, t, 0.5, q);
  EXPECT_NEAR(q[0], 0.1, 1e-12);
  EXPECT_NEAR(q[10], 0.25, 1e-12);
  EXPECT_NEAR(q[5], std::sin(angle / 8), 1e-12);
  EXPECT_NEAR(q[6], std::cos(angle / 8), 1e-12);
  interpolate(*model, t, -1, q);
  EXPECT_EQ(q, t.q.col(0));
  interpolate(*model, t, 5, q);
  EXPECT_EQ(q, t.q.col(1));
}

/// Pushed along the normal through its centre the box resists by its regularisation alone, εM/h² = 0.1 K (S.3) times its increment: a hand in
/// contact stops at p = u − 0.1 (p − p_before).
TEST(Predict, StraightPush_FollowsTheClosedFormForAnyNumberOfSteps) {
  const auto model = load_model("planar_pushing");
  const Plan plan = push_up(model);
  ASSERT_EQ(plan.segments.size(), 2u);
  for (const int n : {1, 2, 30}) {
    Plan out;
    ASSERT_EQ(predict(*model, plan, n, out), core::Status::Solved);
    double u = -0.02, p = -0.02;
    for (const double goal : {0.1, 0.2}) {
      const double u_before = u;
      for (int k = 1; k <= n; ++k) {
        u = u_before + (goal - u_before) * k / n;
        const double contact = std::max(p, 0.0);  // the box is touched at 0: until there the hand follows its command
        p = u <= 0 ? u : (u + 0.1 * contact) / 1.1;
      }
    }
    ASSERT_EQ(out.segments.size(), 2u);
    EXPECT_EQ(out.segments[0].knots.size(), static_cast<std::size_t>(n));
    const VectorXd& end = out.segments.back().knots.back().q;
    EXPECT_NEAR(end[4], p, 1e-7) << n;
    EXPECT_NEAR(end[1], 0.6 + p, 1e-7) << n;
  }
}

/// A hand that slides along the box drags it in one step across Anitescu's gap; sub-steps do that less.
TEST(Predict, SlidingPush_OneStepDiffersFromMany) {
  const auto model = load_model("planar_pushing");
  const VectorXd q = (VectorXd(5) << 0, 0.6, 0, 0, -0.001).finished();
  const Plan plan = push_plan(model, q, {Vector2d(0.0, 0.02), Vector2d(0.4, 0.02)});
  Plan one, many;
  ASSERT_EQ(predict(*model, plan, 1, one), core::Status::Solved);
  ASSERT_EQ(predict(*model, plan, 200, many), core::Status::Solved);
  const double difference = (one.segments.back().knots.back().q - many.segments.back().knots.back().q).head(3).cwiseAbs().maxCoeff();
  EXPECT_GT(difference, 1e-3);
}

/// Springs that are strained or let go cost time (E.9), by the states: predicted in other steps, the same commands would come at other times.
TEST(Retime, StatesPredictedAnew_ComeAtTheTimesOfThePlan) {
  const auto model = load_model("planar_pushing");
  const VectorXd q = (VectorXd(5) << 0, 0.6, 0, 0, -0.001).finished();
  Plan plan, one;
  ASSERT_EQ(predict(*model, push_plan(model, q, {Vector2d(0.0, 0.02), Vector2d(0.4, 0.02), Vector2d(0.4, 0.1)}), 50, plan),
            core::Status::Solved);
  ASSERT_EQ(predict(*model, plan, 3, one), core::Status::Solved);
  const SpeedLimits limits{.load_time = 1e4};
  const Trajectory run = make_trajectory(*model, plan, limits), predicted = make_trajectory(*model, one, limits);
  ASSERT_GT(std::abs(predicted.duration() - run.duration()), 1e-3);
  const Trajectory retimed = retime(predicted, run);
  EXPECT_EQ(retimed.q, predicted.q);
  EXPECT_EQ(retimed.u, predicted.u);
  ASSERT_EQ(retimed.pieces.size(), run.pieces.size());
  for (Eigen::Index k = 1; k < retimed.times.size(); ++k) EXPECT_GT(retimed.times[k], retimed.times[k - 1]) << k;
  for (Eigen::Index k = 0, j = 0; k < retimed.times.size(); ++k) {  // ends of segments
    if (k + 1 < retimed.times.size() && retimed.segments[k + 1] == retimed.segments[k]) continue;
    while (j + 1 < run.times.size() && run.segments[j + 1] <= retimed.segments[k]) ++j;
    EXPECT_NEAR(retimed.times[k], run.times[j], 1e-9) << k;
    EXPECT_EQ(retimed.u.col(k), run.u.col(j)) << k;
  }
  EXPECT_LT((retime(run, run).times - run.times).cwiseAbs().maxCoeff(), 1e-9) << "rounding";
  Trajectory shorter = run;
  shorter.pieces.pop_back();
  EXPECT_NE(message_of([&] { retime(predicted, shorter); }).find("timing.pieces"), std::string::npos);
}

TEST(Trajectory, BadInput_NamesTheField) {
  const auto model = load_model("planar_pushing");
  auto plan = commands_only({{SegmentKind::Contact, {{0.1, 0.0}}}});
  EXPECT_NE(message_of([&] { make_trajectory(*model, plan, {.revolute = 0}); }).find("speed.revolute"), std::string::npos);
  EXPECT_NE(message_of([&] { make_trajectory(*model, plan, {.pause = -1}); }).find("speed.pause"), std::string::npos);
  EXPECT_NE(message_of([&] { make_trajectory(*model, plan, {.ramp = 0}); }).find("speed.ramp"), std::string::npos);
  EXPECT_NE(message_of([&] { make_trajectory(*model, plan, {.landing_factor = 0}); }).find("speed.landing_factor"), std::string::npos);
  EXPECT_NE(message_of([&] { make_trajectory(*model, plan, {.load_time = -1}); }).find("speed.load_time"), std::string::npos);
  EXPECT_NE(
      message_of([&] { make_trajectory(*model, plan, {.revolute = 1e-30, .prismatic = 1e-30}); }).find("speed, pause: got a motion of"),
      std::string::npos);
  plan.segments[0].knots[0].u.resize(3);
  EXPECT_NE(message_of([&] { make_trajectory(*model, plan, SpeedLimits{}); }).find("plan.segments[0].knots[0].u"), std::string::npos);
  plan.segments.clear();
  EXPECT_NE(message_of([&] { make_trajectory(*model, plan, SpeedLimits{}); }).find("plan.segments"), std::string::npos);
  Plan out;
  EXPECT_NE(message_of([&] { (void)predict(*model, plan, 0, out); }).find("substeps"), std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
