// Friction of joints in guarded moves: it is found by a motion before them, taken off, and what it hides makes torques less sure.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
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
using Eigen::VectorXd;
using stiction::test::message_of;
using stiction::test::source_dir;

constexpr double kCoulomb = 0.1, kViscous = 0.1;

/// lower_until_touch with joints that have friction, and the keys of `more`.
TouchScenario rubbing(const std::string& more) {
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
  const std::string urdf =
      replace_all(read(source_dir() / "models/iiwa7_balls.urdf"), joint, joint + R"(<dynamics friction="0.1" damping="0.1"/>)");
  EXPECT_NE(urdf.find("friction=\"0.1\""), std::string::npos);
  std::ofstream(folder / "rubbing.urdf") << urdf;
  const std::string text =
      replace_all(read(source_dir() / "scenarios/lower_until_touch.yaml"), "../models/iiwa7_balls.urdf", "rubbing.urdf");
  std::ofstream(folder / "rubbing.yaml") << text << "plant: {joint_friction: true}\n" << more;
  return tasks::load_touch_scenario(folder / "rubbing.yaml");
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
    sensing::TouchOnset onset(VectorXd::Zero(2), {.noise = VectorXd::Constant(2, kNoise), .friction = friction, .rest_rows = 100});
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
    sensing::TouchOnset onset(VectorXd::Zero(2),
                              {.noise = VectorXd::Constant(2, kNoise), .friction = VectorXd::Constant(2, 0.1), .rest_rows = 100});
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
  sensing::TouchOnset onset(VectorXd::Zero(2), {.noise = VectorXd::Constant(2, kNoise), .friction = VectorXd::Constant(2, 0.1)});
  const VectorXd touch = VectorXd::Constant(2, 3);
  int rows = 0;
  while (!onset.update(touch, kPeriod) && rows < 20) ++rows;
  ASSERT_TRUE(onset.touches());
  for (int k = 0; k < 2000; ++k) ASSERT_TRUE(onset.update(touch, kPeriod));
  EXPECT_GE(onset.noise()(0, 0), 0.1 * 0.1) << "no number of rows tells what friction bears";
  EXPECT_LE(onset.noise()(0, 0), 2 * 0.1 * 0.1);
}

TEST_F(TurningRound, BadFriction_IsNamed) {
  const auto message = [](const VectorXd& friction) {
    return message_of([&] { sensing::TouchOnset(VectorXd::Zero(2), {.noise = VectorXd::Constant(2, kNoise), .friction = friction}); });
  };
  EXPECT_NE(message(VectorXd::Constant(3, 0.1)).find("friction: got 3"), std::string::npos) << message(VectorXd::Constant(3, 0.1));
  EXPECT_NE(message(VectorXd::Constant(2, -0.1)).find("friction: got -0.1"), std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
