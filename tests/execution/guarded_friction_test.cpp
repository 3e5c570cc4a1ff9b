// Friction of joints in guarded moves: it is found by a motion before them, taken off, and what it hides makes torques less sure.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <string>

#include "stiction/execution/touch/guarded_run.hpp"
#include "stiction/sensing/touch_onset.hpp"
#include "stiction/tasks/touch_scenario_file.hpp"
#include "support/message_of.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using stiction::test::message_of;
using stiction::test::source_dir;

constexpr double kCoulomb = 0.1, kViscous = 0.1;

/// A scenario with joints that have friction, and the keys of `more`. @param dynamics  of each joint
TouchScenario rubbing_by_joint(const std::string& name, const std::function<std::string(std::size_t)>& dynamics, const std::string& more) {
  const auto read = [](const std::filesystem::path& file) {
    std::ifstream in(file);
    return std::string((std::istreambuf_iterator<char>(in)), {});
  };
  const auto replace_all = [](std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) text.replace(at, from.size(), to);
    return text;
  };
  const std::filesystem::path folder = stiction::test::folder_of_the_process();
  const std::string joint = R"(type="revolute">)";
  std::string urdf = read(source_dir() / "models/iiwa7_balls.urdf");
  std::size_t joints = 0;
  for (std::size_t at = 0; (at = urdf.find(joint, at)) != std::string::npos; at += joint.size())
    urdf.insert(at + joint.size(), dynamics(joints++));
  EXPECT_EQ(joints, 7u);
  std::ofstream(folder / "rubbing.urdf") << urdf;
  std::string text = replace_all(read(source_dir() / "scenarios" / (name + ".yaml")), "../models/iiwa7_balls.urdf", "rubbing.urdf");
  text = replace_all(text, "../models/", (source_dir() / "models/").string());
  std::ofstream(folder / "rubbing.yaml") << text << "plant: {joint_friction: true}\n" << more;
  return tasks::load_touch_scenario(folder / "rubbing.yaml");
}

/// lower_until_touch with the same friction of all joints.
TouchScenario rubbing(const std::string& more) {
  return rubbing_by_joint(
      "lower_until_touch", [](std::size_t) { return R"(<dynamics friction="0.1" damping="0.1"/>)"; }, more);
}

/// Friction of a Franka (Gaz et al., RA-L 2019; bench/move_until_touch.py) as dry friction.
std::string franka(std::size_t joint) {
  constexpr double kSpan[] = {0.54615, 0.87224, 0.64068, 1.2794, 0.83904, 0.30301, 0.56489};  // from one direction to the other [N·m]
  return fmt::format(R"(<dynamics friction="{}"/>)", 0.5 * kSpan[joint]);
}

GuardedRunResult run(const TouchScenario& scenario, std::uint64_t seed) {
  GuardedRunResult out;
  TouchRunOptions options;
  options.seed = seed;
  EXPECT_EQ(run_guarded(scenario, options, out), Status::Solved) << out.reason;
  return out;
}

TEST(GuardedFriction, MotionBeforeTheMoves_FindsIt) {
  TouchScenario scenario = rubbing("friction_motion: 0.008\n");
  scenario.moves.resize(1);
  const GuardedRunResult out = run(scenario, 1);
  ASSERT_TRUE(out.friction);
  // At the speeds of the motion, up to 0.08 rad/s, damping adds 8 % to dry friction.
  for (const double found : out.friction->coulomb) EXPECT_NEAR(found, kCoulomb, 0.25 * kCoulomb);
  for (const double found : out.friction->viscous) {
    EXPECT_GE(found, 0);
    EXPECT_LE(found, 5 * kViscous);
  }
  EXPECT_TRUE(out.reached) << out.reason;
  ASSERT_EQ(out.moves.size(), 1u);
  EXPECT_LT(std::abs(out.moves[0].correction_error.value()), 3e-3);
  EXPECT_NEAR(out.moves[0].last_force, 5, 1);
}

/// Seeds whose moves pressed with up to 2.9 times what they asked for, as long as contacts that friction makes up bounded the command.
TEST(GuardedFriction, ForcesStayWithinWhatIsAsked) {
  const TouchScenario scenario = rubbing("friction_motion: 0.008\n");
  for (const std::uint64_t seed : {2u, 7u}) {
    SCOPED_TRACE(seed);
    const GuardedRunResult out = run(scenario, seed);
    EXPECT_TRUE(out.reached) << out.reason;
    for (const MoveResult& move : out.moves) {
      if (move.felt.empty()) continue;
      EXPECT_LE(move.late_peak, 1.2 * 5) << move.name;
    }
  }
}

/// Joint 4 hides up to 0.64 N m, a third of what the asked force loads it by.
TEST(GuardedFriction, DryFrictionOfAFranka_IsNoHindrance) {
  for (const std::string name : {"follow_wall", "lower_mug"}) {
    SCOPED_TRACE(name);
    const TouchScenario scenario = rubbing_by_joint(name, franka, "friction_motion: 0.008\n");
    const GuardedRunResult out = run(scenario, 2);
    EXPECT_TRUE(out.reached) << out.reason;
    for (std::size_t i = 0; i < out.moves.size(); ++i) {
      const GuardedMove& move = scenario.moves[i];
      if (!move.until && !move.press) continue;
      EXPECT_LE(out.moves[i].late_peak, 1.2 * (move.until ? move.until->force : scenario.arm.controller.lambda_max)) << move.name;
    }
  }
}

TEST(GuardedFriction, FrictionThatIsNotKnown_IsTakenForATouch) {
  TouchScenario scenario = rubbing("");
  scenario.moves.resize(1);
  int reached = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u}) reached += run(scenario, seed).reached;
  EXPECT_LT(reached, 3) << "the other test would say nothing";
}

TEST(GuardedFriction, SomethingInTheWayOfTheMotion_IsSaid) {
  TouchScenario scenario = rubbing("friction_motion: 0.1\n");  // the tool goes down by 8 cm
  const GuardedRunResult out = run(scenario, 1);
  EXPECT_FALSE(out.reached);
  EXPECT_TRUE(out.moves.empty());
  EXPECT_NE(out.reason.find("is something in its way?"), std::string::npos) << out.reason;
}

/// A joint that turns round, between rows without noise: its torque changes by twice the friction.
class TurningRound : public testing::Test {
 protected:
  static constexpr double kNoise = 0.01, kPeriod = 0.005;
  static bool alarms(const VectorXd& friction, double change) {
    sensing::TouchOnset onset(VectorXd::Zero(2),
                              {.noise = kNoise * kNoise * MatrixXd::Identity(2, 2), .friction = friction, .rest_rows = 100});
    VectorXd tau = VectorXd::Zero(2), sign = VectorXd::Zero(2);
    for (int k = 0; k < 200; ++k) {
      sign[0] = std::tanh((k - 100) / 20.0);
      tau[0] = change * sign[0];
      if (onset.update(tau, kPeriod, sign)) return true;
    }
    return false;
  }
};

TEST_F(TurningRound, FrictionIsNoTouch_UnlessItIsNotKnown) {
  EXPECT_FALSE(alarms(VectorXd::Constant(2, 0.1), 0.1));
  EXPECT_TRUE(alarms(VectorXd(), 0.1)) << "without friction such a change is a touch";
  EXPECT_TRUE(alarms(VectorXd::Constant(2, 0.1), 2)) << "more than friction can be is a touch";
}

/// A touch that comes as slowly as an arm presses at a millimetre a second, on joints that stick: friction explains no more than its size.
TEST_F(TurningRound, TouchThatComesSlowly_IsNoFriction) {
  for (const double rise : {0.2, 0.5, 1.0}) {  // [N·m/s]
    SCOPED_TRACE(rise);
    sensing::TouchOnset onset(
        VectorXd::Zero(2), {.noise = kNoise * kNoise * MatrixXd::Identity(2, 2), .friction = VectorXd::Constant(2, 0.1), .rest_rows = 100});
    VectorXd tau = VectorXd::Zero(2);
    double felt = 0;
    for (int k = 0; k < 2000 && felt == 0; ++k) {
      tau[0] = rise * k * kPeriod;
      if (onset.update(tau, kPeriod)) felt = tau[0];
    }
    EXPECT_GT(felt, 0) << "never";
    EXPECT_LT(felt, 5 * 0.1);
    for (int k = 0; k < 400; ++k) ASSERT_TRUE(onset.update(VectorXd::Constant(2, 1), kPeriod)) << "what is held is felt";
  }
}

TEST_F(TurningRound, WhatAJointThatSticksHides_MakesTheTouchLessSure) {
  sensing::TouchOnset onset(VectorXd::Zero(2),
                            {.noise = kNoise * kNoise * MatrixXd::Identity(2, 2), .friction = VectorXd::Constant(2, 0.1)});
  const VectorXd touch = VectorXd::Constant(2, 3);
  int rows = 0;
  while (!onset.update(touch, kPeriod) && rows < 20) ++rows;
  ASSERT_TRUE(onset.touches());
  for (int k = 0; k < 2000; ++k) ASSERT_TRUE(onset.update(touch, kPeriod));
  // Before the touch and in it, friction may have any value within ± its size: twice a third of its square.
  EXPECT_GE(onset.noise()(0, 0), 0.99 * 2.0 / 3 * 0.1 * 0.1) << "no number of rows tells what friction bears";
  EXPECT_LE(onset.noise()(0, 0), 2 * 0.1 * 0.1);
}

/// A joint at rest bears 0.1 N m by friction, and then slides: this shows its offset, so a touch is measured from there and not from the rest.
TEST_F(TurningRound, JointThatSlides_ShowsItsOffset) {
  sensing::TouchOnset onset(
      VectorXd::Constant(1, 0.1),
      {.noise = kNoise * kNoise * MatrixXd::Identity(1, 1), .friction = VectorXd::Constant(1, 0.1), .rest_rows = 100});
  VectorXd tau = VectorXd::Constant(1, 0.1), sign = VectorXd::Zero(1);
  for (int k = 0; k < 400; ++k) {
    sign[0] = std::tanh(std::max(0, k - 20) / 10.0);
    tau[0] = 0.1 * (1 - sign[0]);
    ASSERT_FALSE(onset.update(tau, kPeriod, sign)) << k;
  }
  tau[0] = 1, sign[0] = 0;
  for (int k = 0; k < 10; ++k) (void)onset.update(tau, kPeriod, sign);
  ASSERT_TRUE(onset.touches());
  EXPECT_NEAR(onset.rest()[0], 0, 3 * kNoise);
  EXPECT_LT(onset.noise()(0, 0), 0.5 * 0.1 * 0.1) << "only friction during the touch is unknown";
}

TEST_F(TurningRound, TouchThatIsKept_DoesNotEnd) {
  sensing::TouchOnset onset(VectorXd::Zero(2), {.noise = kNoise * kNoise * MatrixXd::Identity(2, 2)});
  const auto update = [&](double tau) { return onset.update(VectorXd::Constant(2, tau), kPeriod); };
  for (int k = 0; k < 20; ++k) (void)update(1);
  ASSERT_TRUE(onset.touches());
  onset.keep_touch(true);
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(update(0));
  onset.keep_touch(false);
  for (int k = 0; k < 20; ++k) (void)update(0);
  EXPECT_FALSE(onset.touches());
}

TEST_F(TurningRound, BadFriction_IsNamed) {
  const auto message = [](const VectorXd& friction) {
    return message_of(
        [&] { sensing::TouchOnset(VectorXd::Zero(2), {.noise = kNoise * kNoise * MatrixXd::Identity(2, 2), .friction = friction}); });
  };
  EXPECT_NE(message(VectorXd::Constant(3, 0.1)).find("friction: got 3"), std::string::npos) << message(VectorXd::Constant(3, 0.1));
  EXPECT_NE(message(VectorXd::Constant(2, -0.1)).find("friction: got -0.1"), std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
