#include "stiction/execution/open_loop/run_timing.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "planning/push_plan.hpp"
#include "stiction/execution/open_loop/lag_allowance.hpp"
#include "stiction/execution/open_loop/push_travel.hpp"
#include "stiction/execution/open_loop/spring_load.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution::test {
namespace {

using Eigen::VectorXd;
using planning::SegmentKind;
using planning::test::load_model;

constexpr double kUnled = 0.1;  ///< slower than what any of these pushes needs
constexpr double kReach = 0.6;  ///< between the centres of the box and of the pusher where they touch [m]

/// Commands of the pusher alone, beside the box: from x = 0 to 1 the gap is |y_box − y| − kReach.
planning::Plan free_motion(const std::vector<Eigen::Vector2d>& corners, SegmentKind kind, double y_box = 5) {
  planning::Plan plan;
  plan.q_start = (VectorXd(5) << 0.5, y_box, 0, corners[0][0], corners[0][1]).finished();
  plan.u_start = corners[0];
  planning::Segment segment{kind, {}};
  for (std::size_t k = 1; k < corners.size(); ++k) {
    VectorXd q = plan.q_start;
    q.tail<2>() = corners[k];
    segment.knots.push_back({corners[k], q, {}});
  }
  plan.segments = {segment};
  return plan;
}

double speed_at(const execution::Trajectory& t, Eigen::Index k) {
  return ((t.u.col(k + 1) - t.u.col(k)) / (t.times[k + 1] - t.times[k])).cwiseAbs().maxCoeff();
}

/// The finger of a gripper with 20 N and 100 N·s/m, and an armature of 1 kg on 1000 N/m.
TEST(RunSpeeds, JointWithDampingAndArmature_GoesAsItsMotorCan) {
  const auto speeds = [](const std::string& joint) {
    world::Scene scene;
    scene.name = "test";
    world::RobotSpec robot;
    robot.name = "hand";
    robot.mjcf = "hand.xml";
    robot.text = "<mujoco><worldbody><body><joint name='x' type='slide' axis='1 0 0' range='0 .1' " + joint +
                 "/><geom size='.01' mass='0.01'/></body></worldbody><actuator><position joint='x' kp='1000' forcelimited='true' "
                 "forcerange='-20 20'/></actuator></mujoco>";
    scene.robots.push_back(robot);
    world::ObjectSpec ball;
    ball.name = "ball";
    ball.mass = 0.1;
    ball.inertia = 1e-4 * Eigen::Matrix3d::Identity();
    ball.X_WP.p = {1, 0, 0};
    ball.geometries.push_back({.name = "shape", .shape = world::Sphere{0.05}, .X_BG = {}, .friction = 1});
    scene.objects.push_back(ball);
    return calc_run_speeds(*world::Model::make(scene), 0);
  };
  const RunSpeeds light = speeds(""), heavy = speeds("armature='1' damping='100'");
  EXPECT_EQ(light.most[0], std::numeric_limits<double>::infinity());
  EXPECT_NEAR(heavy.most[0], 0.5 * 20 / 100, 1e-12);
  EXPECT_NEAR(heavy.acceleration[0] / light.acceleration[0], 0.01 / 1.01, 1e-9);
}

/// Half of the distance to what is nearest.
TEST(LagAllowance, IsAShareOfTheDistance) {
  const auto model = load_model("planar_pushing");
  const double least = calc_run_speeds(*model, 0).room, most = model->scales().robots().length;
  LagAllowance room(*model, least);
  const auto calc = [&](double gap0, double gap1) {
    const auto q = [](double gap) { return (VectorXd(5) << 0.5, kReach + gap, 0, 0.5, 0).finished(); };
    return room.calc(Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 1), q(gap0), q(gap1));
  };
  EXPECT_NEAR(calc(most, 0.5 * most), 0.25 * most, 1e-9) << "where it is nearer";
  EXPECT_NEAR(calc(0.5 * most, most), 0.25 * most, 1e-9);
  EXPECT_EQ(calc(most, 0), least) << "in contact";
  EXPECT_EQ(calc(9 * most, 9 * most), most) << "far from everything";
  const VectorXd q = (VectorXd(5) << 0.5, 5, 0, 0.5, 0).finished();
  EXPECT_EQ(room.calc(Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0), q, q), least) << "nothing moves";
}

/// One finger moves, and the other one, at the ball and holding it, gives a little.
TEST(LagAllowance, BranchThatHolds_DoesNotMove) {
  const auto model = load_model("planar_hand");
  const double least = calc_run_speeds(*model, 0).room;
  VectorXd q = model->neutral();
  q.head<2>() << 0.3, 0.3 + 2 * least;  // a ball of 0.25 m above the right finger of 0.05 m, which lies along y
  const VectorXd u = q.tail(model->n_a());
  LagAllowance room(*model, least);
  /// @param left, right  how far the command of a joint of each moves   @param gives  a joint of the right one
  const auto calc = [&](double left, double right, double gives) {
    VectorXd u_next = u, q_next = q;
    u_next[0] += left;
    u_next[model->n_a() - 1] += right;
    q_next[model->n_q() - 1] += gives;
    return room.calc(u, u_next, q, q_next);
  };
  const double alone = calc(1e-3, 0, 0), both = calc(1e-3, 1e-3, 0);
  ASSERT_GT(alone, 2 * both) << "or the test would say nothing";
  EXPECT_NEAR(calc(1e-3, 0, 1e-9), alone, 1e-6);
}

/// From the speed of pushes v up with a, along, and down to v: over a way w within 2 (√(v² + a w) − v)/a. a grows with the room that there is, as far as motors
/// can make use of it.
TEST(RunTiming, RegraspOverALine_TakesTheTimeOfItsAcceleration) {
  const auto model = load_model("planar_pushing");
  RunSpeeds speeds = calc_run_speeds(*model, 0);
  const double v = speeds.push[0], way = 1;
  ASSERT_LT(v, 0.3 * std::sqrt(speeds.acceleration[0] * way)) << "or the test would say nothing";
  struct Case {
    SegmentKind kind;
    double gap, most_room, times;  // of RunSpeeds::room; of its acceleration
  };
  for (const Case& c : {Case{SegmentKind::Regrasp, 1, 50, 1}, Case{SegmentKind::Contact, 1, 50, 1}, Case{SegmentKind::Regrasp, 6, 50, 3},
                        Case{SegmentKind::Regrasp, 6, 2, 2}}) {
    speeds.most_room.setConstant(c.most_room * speeds.room);
    const double a = c.times * speeds.acceleration[0];
    const auto t = make_trajectory(*model, free_motion({{0, 0}, {0.5 * way, 0}, {way, 0}}, c.kind, kReach + c.gap * speeds.room), speeds);
    const double v_end = c.kind == SegmentKind::Regrasp ? v : 0;
    EXPECT_NEAR(t.duration(), 2 * (std::sqrt(v_end * v_end + a * way) - v_end) / a, 1e-6 * t.duration());
    double fastest = 0;
    for (Eigen::Index k = 0; k + 1 < t.times.size(); ++k) {
      fastest = std::max(fastest, speed_at(t, k));
      if (k > 0) {
        EXPECT_LE(std::abs(speed_at(t, k) - speed_at(t, k - 1)), a * (t.times[k + 1] - t.times[k - 1])) << k;
      }
    }
    EXPECT_NEAR(fastest, std::sqrt(v_end * v_end + a * way), 0.02 * a) << "over parts of 0.02 s";
    EXPECT_TRUE((t.u.row(0).tail(t.times.size() - 1).array() > t.u.row(0).head(t.times.size() - 1).array()).all());
  }
}

/// K_a lag = τ/2 at the most room that a motor can make use of.
TEST(RunSpeeds, MostRoom_IsThatOfHalfOfTheEffort) {
  const auto model = load_model("planar_pushing");
  const RunSpeeds speeds = calc_run_speeds(*model, 0);
  for (int j = 0; j < model->n_a(); ++j)
    EXPECT_NEAR(model->stiffness()[j] * speeds.most_room[j] / model->reach()[j], 0.5 * model->effort()[j], 1e-9);
}

TEST(RunTiming, CornerOfARegrasp_IsPassedSlowly) {
  const auto model = load_model("planar_pushing");
  RunSpeeds speeds = calc_run_speeds(*model, 0);
  speeds.most_room.setConstant(std::numeric_limits<double>::infinity());
  for (const double times : {1.0, 3.0}) {
    const double y_box = -kReach - 2 * times * speeds.room;
    const auto t = make_trajectory(*model, free_motion({{0, 0}, {1, 0}, {1, 1}}, SegmentKind::Regrasp, y_box), speeds);
    const double a = times * speeds.acceleration[0], jump = times * speeds.jump[0];
    bool passed = false;
    for (Eigen::Index k = 0; k + 2 < t.times.size(); ++k) {
      if (t.u(0, k + 1) != 1 || t.u(1, k + 1) != 0) continue;
      passed = true;
      for (const Eigen::Index part : {k, k + 1}) {  // mean speeds from or to that of the corner
        const double way = (t.u.col(part + 1) - t.u.col(part)).norm();
        EXPECT_GT(speed_at(t, part), jump) << times;
        EXPECT_LT(speed_at(t, part), std::sqrt(jump * jump + 2 * a * way)) << times;
      }
    }
    EXPECT_TRUE(passed);
  }
}

TEST(RunTiming, JointsKeepToTheSpeedOfTheirMotors) {
  const auto model = load_model("planar_pushing");
  RunSpeeds speeds = calc_run_speeds(*model, 0);
  speeds.most.setConstant(0.4);
  const auto t = make_trajectory(*model, free_motion({{0, 0}, {3, 1}}, SegmentKind::Regrasp), speeds);
  for (Eigen::Index k = 0; k + 1 < t.times.size(); ++k) EXPECT_LE(speed_at(t, k), 0.4 * (1 + 1e-9));
  EXPECT_NEAR(t.duration(), 3 / 0.4, 0.3);
}

/// What is free, round a corner and to the speed of motors, and what strains springs: the same in ten times the time.
TEST(RunTiming, SlowerRun_IsTheSameInSlowerTime) {
  const auto model = load_model("planar_pushing");
  RunSpeeds speeds = calc_run_speeds(*model, 0), slow = calc_run_speeds(*model, 0, 0.1);
  speeds.start_time = slow.start_time = 0;  // 4 τ, however slow
  EXPECT_EQ(calc_run_speeds(*model, 0, 2).most, speeds.most) << "no motor is faster for it";
  EXPECT_NEAR(slow.object, 0.1 * speeds.object, 1e-12);
  EXPECT_NEAR((slow.push - 0.1 * speeds.push).norm(), 0, 1e-12);
  planning::Plan strained = free_motion({{0, 0}, {1, 0}}, SegmentKind::Contact);
  strained.segments[0].knots[0].q.tail<2>().setZero();  // something holds the pusher
  for (const planning::Plan& plan : {free_motion({{0, 0}, {1, 0}, {1, 3}}, SegmentKind::Regrasp, 50), strained}) {
    const auto fast = make_trajectory(*model, plan, speeds), t = make_trajectory(*model, plan, slow);
    EXPECT_NEAR(t.duration(), 10 * fast.duration(), 0.01 * t.duration());
    VectorXd u(2);
    for (Eigen::Index k = 0; k < fast.times.size(); ++k) {
      interpolate_command(t, 10 * fast.times[k], u);
      EXPECT_NEAR((u - fast.u.col(k)).norm(), 0, 0.01) << k;
    }
  }
}

/// A cube that stands on a tray, or on the ground beside a tray that pushes it, goes there and back.
TEST(RunTiming, WhatIsCarried_IsNotShaken) {
  const auto model = world::Model::make(world::parse_scene(
      "gravity: [0, 0, -9.81]\n"
      "robots: [{name: r, mjcf: \"<mujoco><worldbody><body><joint name='x' type='slide' axis='1 0 0' range='-2 2'/><inertial mass='1' "
      "pos='0 0 0' diaginertia='1 1 1'/><body><joint name='z' type='slide' axis='0 0 1' range='-2 2'/><geom type='box' size='.1 .1 .01' "
      "mass='1'/></body></body></worldbody><actuator><position joint='x' kp='1000'/><position joint='z' "
      "kp='1000'/></actuator></mujoco>\"}]\n"
      "objects: [{name: cube, joint: free, mass: 0.2, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}]\n"
      "fixed: [{name: ground, shapes: [{half_space: {}}]}]\n",
      "."));
  const RunSpeeds speeds = calc_run_speeds(*model, 0);
  const double most = 0.2 * 9.81;  // s_g g of (E.26)
  for (const bool carried : {true, false}) {
    planning::Plan plan;
    plan.q_start = VectorXd::Zero(model->n_q());
    plan.q_start.head<3>() << (carried ? 0 : 0.15), 0, (carried ? 0.56 : 0.05);
    plan.q_start[6] = 1;
    plan.u_start = Eigen::Vector2d(0, carried ? 0.5 : 0.05);
    plan.q_start.tail<2>() = plan.u_start;
    plan.segments = {{SegmentKind::Contact, {}}};
    for (const double x : {0.3, 0.0}) {
      VectorXd q = plan.q_start, u = plan.u_start;
      q[0] += x, q[model->n_q() - 2] += x, u[0] += x;
      plan.segments[0].knots.push_back({u, q, {}});
    }
    const double v = speeds.object, at_end = speeds.carry_jump[0], at_corner = 0.5 * at_end;
    const double ramps = (2 * v * v - at_end * at_end - at_corner * at_corner) / (2 * most), way = 0.3;
    const double carefully = (2 * v - at_end - at_corner) / most + (way - ramps) / v;
    ASSERT_LT(at_end, 0.5 * v) << "or the test would say nothing";
    EXPECT_NEAR(make_trajectory(*model, plan, speeds).duration(), 2 * (carried ? carefully : way / v), 0.01 * way / v);
  }
}

/// A box of 1 m, a ball of 0.1 m below it.
TEST(PushTravel, IsThatOfTheObjectAndOfWhatTouchesIt) {
  const auto model = load_model("planar_pushing");
  PushTravel travel(*model);
  const auto calc = [&](std::array<double, 5> q0, std::array<double, 5> q1) {
    return travel.calc(Eigen::Map<const VectorXd>(q0.data(), 5), Eigen::Map<const VectorXd>(q1.data(), 5));
  };
  EXPECT_NEAR(calc({0, 0.6, 0, 4, 0}, {0.03, 0.64, 0, 5, 0}), 0.05, 1e-12) << "moved";
  EXPECT_NEAR(calc({0, 0.6, 0, 5, 0}, {0, 0.6, 0.1, 5, 0}), 0.1 * 0.5 * model->scales().object(0).length, 1e-12) << "turned";
  EXPECT_EQ(calc({0, 0.6, 0, 5, 0}, {0, 0.6, 0, 6, 0}), 0) << "touches nothing";
  EXPECT_NEAR(calc({0, 0.6, 0, 0, 0}, {0, 0.6, 0, 0.2, 0}), 0.2, 1e-12) << "slides along the box";
  EXPECT_NEAR(calc({0, 0.6, 0, 0, 0}, {0, 0.6, 0, 0, -0.2}), 0.2, 1e-12) << "lets go";
  EXPECT_NEAR(calc({0, 0.6, 0, 0, -0.2}, {0, 0.6, 0, 0, 0}), 0.2, 1e-12) << "lands";
}

/// However the joints move, the box has the speed v of (E.13) between the ramps at both ends of the push.
TEST(RunTiming, PushTakesItsObjectAtTheSpeedOfObjects) {
  const auto model = load_model("planar_pushing");
  const RunSpeeds speeds = calc_run_speeds(*model, 0);
  EXPECT_EQ(speeds.object, speeds.push[0]) << "of sliders";
  const auto t = make_trajectory(*model, planning::test::push_up(model), speeds);
  double fastest = 0;
  for (Eigen::Index k = 0; k + 1 < t.times.size(); ++k)
    fastest = std::max(fastest, (t.q.col(k + 1) - t.q.col(k)).head<2>().norm() / (t.times[k + 1] - t.times[k]));
  EXPECT_LE(fastest, speeds.object * (1 + 1e-9));
  EXPECT_GT(fastest, 0.95 * speeds.object);
}

/// A straight push of a box of 5 kg, damped by m/τ = 100 N·s/m, by a spring of 100 N/m: commands are ahead by D v/K more than those of the plan.
TEST(DragFeedforward, StraightPush_LeadsByDampingOverStiffness) {
  const auto model = load_model("planar_pushing");
  const planning::Plan plan = planning::test::push_up(model);
  DragFeedforward lead(model);
  ASSERT_TRUE(lead.acts());
  const auto& knots = plan.segments.back().knots;
  const auto &from = knots[knots.size() - 2], &to = knots.back();
  const double way = (to.q - from.q)[1], duration = 0.2;
  ASSERT_GT(way, 0.01);
  const auto led = lead.calc(plan, from.q, to.u, to.q, duration, kUnled);
  EXPECT_EQ(led.speed, 1);
  EXPECT_NEAR(led.strain[1], 100 * way / duration / 100, 0.02 * led.strain[1]);
  EXPECT_NEAR(led.strain[0], 0, 1e-6);

  const RunSpeeds speeds = calc_run_speeds(*model, 0);
  const auto plain = make_trajectory(*model, plan, speeds), ahead = make_trajectory(*model, plan, speeds, &lead);
  EXPECT_NEAR((ahead.u.col(ahead.u.cols() - 1) - plain.u.col(plain.u.cols() - 1)).norm(), 0, 1e-12) << "at rest at its end";
  EXPECT_NEAR((ahead.u - ahead.q.bottomRows(2)).row(1).maxCoeff(), speeds.push[1] * 1.0, 0.1 * speeds.push[1]) << "T_f v in the middle";
}

/// A slider of 5 kg with 60 N·s/m of its own, on what gives m/τ = 100 N·s/m.
TEST(DragFeedforward, DampingOfTheJointItself_IsLedToo) {
  const auto model = world::Model::make(world::parse_scene(
      "robots: [{name: r, mjcf: \"<mujoco><worldbody><body><joint name='x' type='slide' axis='1 0 0' range='-1 1'/><inertial mass='1' "
      "pos='0 0 0' diaginertia='1 1 1'/><body><joint name='y' "
      "type='slide' "
      "axis='0 1 0' range='-1 1'/><geom size='.05' mass='1'/></body></body></worldbody><actuator><position joint='x' kp='100'/><position "
      "joint='y' "
      "kp='100'/></actuator></mujoco>\"}]\n"
      "objects: [{name: drawer, joint: slider, axis: [0, 1, 0], mass: 5, joint_damping: 60, shapes: [{box: {size: [0.2, 0.2, 0.2]}}]}]\n",
      "."));
  const planning::Plan plan =
      planning::test::push_plan(model, Eigen::Vector3d(0.15, 0, -0.02), {Eigen::Vector2d(0, 0.1), Eigen::Vector2d(0, 0.2)});
  const auto& knots = plan.segments.back().knots;
  const auto &from = knots[knots.size() - 2], &to = knots.back();
  const double way = to.q[0] - from.q[0], duration = 0.2;
  ASSERT_GT(way, 0.01);
  const auto led = DragFeedforward(model).calc(plan, from.q, to.u, to.q, duration, kUnled);
  EXPECT_NEAR(led.strain[1], (5 / 0.05 + 60) * way / duration / 100, 0.02 * led.strain[1]);
}

/// Leads strain springs at once where a push begins; joints that are slow take their time for it.
TEST(RunTiming, CommandsWithLeads_AreNoFasterThanTheirJoints) {
  const auto model = load_model("planar_pushing");
  const planning::Plan plan = planning::test::push_up(model);
  DragFeedforward lead(model);
  ASSERT_TRUE(lead.acts());
  for (const double factor : {0.1, 1.0, 1000.0}) {
    RunSpeeds speeds = calc_run_speeds(*model, 0, factor);
    const double usual = speeds.push[1];
    for (const double limit : {0.02 * usual, 0.5 * usual, 1.2 * usual}) {
      speeds.most.setConstant(limit);
      speeds.push = speeds.push.cwiseMin(limit);
      const auto t = make_trajectory(*model, plan, speeds, &lead);
      double fastest = 0;
      for (Eigen::Index k = 0; k + 1 < t.times.size(); ++k) fastest = std::max(fastest, speed_at(t, k));
      EXPECT_LE(fastest, limit * (1 + 1e-9)) << factor;
      if (limit < 0.1 * usual) {
        EXPECT_GT(fastest, 0.9 * limit) << factor << ": the joints set the pace";
      }
      EXPECT_EQ(t.speed, factor);
    }
  }
}

/// 100 N of the motor are the most that the damping of 100 N·s/m may ask for.
TEST(DragFeedforward, MotorThatCannotPushSoFast_MakesThePushSlower) {
  const auto model = load_model("planar_pushing");
  const planning::Plan plan = planning::test::push_up(model);
  const auto& knots = plan.segments.back().knots;
  const auto &from = knots[knots.size() - 2], &to = knots.back();
  const double way = (to.q - from.q)[1], duration = way / 2;  // 2 m/s, 200 N
  const auto led = DragFeedforward(model).calc(plan, from.q, to.u, to.q, duration, kUnled);
  EXPECT_NEAR(led.speed, 0.8 * 100 / 200, 0.01 * 0.8 * 100 / 200);
  EXPECT_EQ(DragFeedforward(model).calc(plan, from.q, to.u, to.q, duration, 0.7).speed, 0.7) << "where it needs no lead";
}

/// The pusher goes away from the box, or the plan has the box move with nothing at it: there is nothing to lead, and to be slow would not help.
TEST(DragFeedforward, StepThatPushesNothing_HasNone) {
  const auto model = load_model("planar_pushing");
  const planning::Plan plan = planning::test::push_up(model);
  const auto& knots = plan.segments.back().knots;
  const auto& from = knots[knots.size() - 2];
  const auto calc = [&](double box, double pusher) {
    VectorXd q = from.q;
    q[1] += box, q.tail<2>()[1] += pusher;
    return DragFeedforward(model).calc(plan, from.q, q.tail<2>(), q, 0.2, 0.6);
  };
  const auto away = calc(0, -0.1), alone = calc(0.1, -0.1);
  EXPECT_EQ(away.speed, 1);
  EXPECT_EQ(away.strain.norm(), 0);
  EXPECT_EQ(alone.speed, 0.6) << "slow enough to trail";
  EXPECT_EQ(alone.strain.norm(), 0);
}

/// Let go of: what bears no more than f T as before, and of e times as much by one T more.
TEST(SpringLoad, TimeToLetGo_GrowsWithTheLogarithmOfTheForce) {
  const auto model = load_model("planar_pushing");
  const RunSpeeds speeds = calc_run_speeds(*model, 0);
  const SpringLoad springs(*model, speeds);
  const double T = speeds.spring_time[1], unit = speeds.springs[1] * T;  // of strain
  const auto time = [&](double strain, int parts) {
    double sum = 0;
    for (int i = 0; i < parts; ++i)
      sum += springs.calc_time(Eigen::Vector2d(0, (i + 1) * strain / parts), Eigen::Vector2d(0, i * strain / parts));
    return sum;
  };
  EXPECT_NEAR(springs.calc_time(Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0.1 * unit)), 0.1 * T, 1e-12) << "from nothing";
  for (const double times : {1.0, 10.0, 100.0}) EXPECT_NEAR(time(times * unit, 20000), T * std::log1p(times), 0.01 * T * std::log1p(times));
  const Eigen::Vector2d least(0, 10 * unit), along(0.5 * unit, 10 * unit);
  EXPECT_NEAR(springs.calc_time(least, along), 0.5 * T / 11 * speeds.spring_time[0] / T, 1e-6) << "one joint with what the branch bears";
  EXPECT_EQ(springs.count_parts(least, least), 1);
  EXPECT_EQ(springs.count_parts(Eigen::Vector2d(0, 0), least), 10);
}

/// A spring on its joint trails a force that grows by e in T by 1/(T ω)², the share of the coast.
TEST(RunSpeeds, SpringTime_LetsTheSlowestJointOfABranchFollow) {
  const auto model = load_model("planar_pushing");
  const RunSpeeds speeds = calc_run_speeds(*model, 0);
  for (int j = 0; j < 2; ++j) {
    const double omega = std::numbers::e * speeds.acceleration[j] / speeds.jump[j];
    EXPECT_GE(speeds.spring_time[j] * omega, 1 / std::sqrt(kCoast) * (1 - 1e-9)) << j;
  }
}

TEST(DragFeedforward, FreeObject_HasNone) {
  world::Scene scene = load_model("allegro_cube")->scene();
  scene.objects[0].joint_damping = 0.01;
  EXPECT_FALSE(DragFeedforward(world::Model::make(scene)).acts());
}

}  // namespace
}  // namespace stiction::execution::test
