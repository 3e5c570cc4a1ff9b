// A hand that presses on an arm through a spring, moves along it, and is bounded as any other contact.
#include "stiction/execution/contact_control/hand_push.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "stiction/execution/contact_control/control_run.hpp"
#include "stiction/tasks/control_scenario_file.hpp"
#include "support/message_of.hpp"
#include "support/paths.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using stiction::test::message_of;
using stiction::test::source_dir;
using tasks::load_control_scenario;
using tasks::parse_control_scenario;

HandPush hand() {
  return {.body = 3,
          .direction_W = Vector3d::UnitY(),
          .stiffness = 200,
          .knots = {{0, {0, 0, 0.1}, 0}, {2, {0, 0, 0.1}, 0.08}, {4, {0, 0, 0.3}, 0.08}}};
}

TEST(Hand, BetweenItsKnots_MovesFromRestToRest) {
  EXPECT_EQ(calc_hand(hand(), 0).depth, 0);
  EXPECT_NEAR(calc_hand(hand(), 0.5).depth, 0.08 * (3.0 / 16 - 2.0 / 64), 1e-15);
  EXPECT_NEAR(calc_hand(hand(), 3).p_L.z(), 0.2, 1e-15);
  EXPECT_NEAR(calc_hand(hand(), 9).p_L.z(), 0.3, 1e-15) << "held after the last knot";
  EXPECT_EQ(calc_hand(hand(), 9).depth, 0.08);
}

TEST(Hand, ForceIsThatOfItsSpring_AndNeverPulls) {
  world::Pose start, now;
  EXPECT_NEAR(calc_push(hand(), start, now, 2).force_W.y(), 200 * 0.08, 1e-12);
  now.p.y() = 0.03;  // yields
  EXPECT_NEAR(calc_push(hand(), start, now, 2).force_W.y(), 200 * 0.05, 1e-12);
  EXPECT_EQ(calc_push(hand(), start, now, 2).p_BP, Vector3d(0, 0, 0.1));
  now.p.y() = 0.09;  // away from it
  EXPECT_TRUE(calc_push(hand(), start, now, 2).force_W.isZero(0));
  now.p = Vector3d(0.5, 0, -0.5);  // across its direction
  EXPECT_NEAR(calc_push(hand(), start, now, 2).force_W.y(), 200 * 0.08, 1e-12);
}

/// At rest the hand's spring and the arm bear the same force: k (depth − y) = k_arm y without a bound, and the bound with one.
TEST(Hand, ArmYieldsWhereItsForceIsBounded) {
  ControlScenario scenario = load_control_scenario(source_dir() / "scenarios" / "push_along_arm.yaml");
  scenario.hand.knots.resize(2);  // it stays where it has come to
  scenario.duration = scenario.hand.knots.back().time + 1.5;
  ControlRunResult ours, stiff;
  ASSERT_EQ(run_control(scenario, {}, ours), Status::Solved);
  scenario.controller.law = control::Law::Unconstrained;
  ASSERT_EQ(run_control(scenario, {}, stiff), Status::Solved);
  const auto& force = ours.samples.back().forces;
  ASSERT_EQ(force.size(), 1u);
  EXPECT_EQ(force[0].pair, -1);
  EXPECT_NEAR(force[0].force_W.normalized().y(), 1, 1e-12);
  EXPECT_NEAR(ours.samples.back().largest_force, 15, 0.05 * 15);
  EXPECT_GT(stiff.samples.back().largest_force, 2 * 15);
  EXPECT_GT(ours.samples.back().error, 2 * stiff.samples.back().error) << "it yields more";
}

TEST(HandScenario, BadInput_NamesTheField) {
  std::ifstream in(source_dir() / "scenarios" / "push_along_arm.yaml");
  const std::string good((std::istreambuf_iterator<char>(in)), {});
  const auto message = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return message_of([&] { (void)parse_control_scenario(text, source_dir() / "scenarios"); });
  };
  EXPECT_EQ(message("hold: 1", "hold: 1"), "no exception");
  EXPECT_NE(message("link: arm/link_5", "link: arm/link_55").find("arm/link_55"), std::string::npos);
  EXPECT_NE(message("[0, 1, 0]", "[0, 0, 0]").find("hand.direction: got"), std::string::npos);
  EXPECT_NE(message("stiffness: 1000", "stiffness: 0").find("hand.stiffness: got 0"), std::string::npos);
  EXPECT_NE(message("time: 14", "time: 1").find("hand.knots[2].time: got 1, expected more than 10 s"), std::string::npos);
  EXPECT_NE(message("depth: 0}", "depth: 0.01}").find("hand.knots[0]"), std::string::npos);
  EXPECT_NE(message("depth: 0.06", "depth: -1").find("hand.knots[1].depth: got -1"), std::string::npos);
  EXPECT_NE(message("lambda_max: 15", "lambda_max: 0").find("controller.lambda_max: got 0"), std::string::npos);
}

/// A hand that nobody knew of: it is one of the contacts from the tick on in which it begins, moves the arm as the springs let it, and is gone when it lets go.
TEST(Hand, HeldWhileTheLoopRuns_IsAContactUntilItLetsGo) {
  ControlScenario scenario = load_control_scenario(source_dir() / "scenarios" / "box_in_the_way.yaml");
  scenario.start = scenario.model->neutral().tail(scenario.model->n_a());  // away from the box
  scenario.start[3] = -1;
  ControlLoop loop(scenario, scenario.model);
  ControlSample sample;
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(6);
  const auto run = [&](int ticks) {
    for (int k = 0; k < ticks; ++k) ASSERT_EQ(loop.tick(still, sample), Status::Solved) << loop.message();
  };
  run(40);
  ASSERT_TRUE(sample.forces.empty());
  const Eigen::VectorXd before = loop.q();
  int link = -1;
  for (std::size_t b = 0; b < scenario.model->bodies().size(); ++b)
    if (scenario.model->bodies()[b].name == "arm/link_4") link = static_cast<int>(b);
  loop.hold_push({.body = link, .p_BP = Vector3d::Zero(), .force_W = {12, 0, 0}});
  run(1);
  ASSERT_EQ(sample.forces.size(), 1U);
  EXPECT_EQ(sample.forces[0].pair, -1);
  EXPECT_EQ(sample.largest_force, 12);
  ASSERT_EQ(sample.reported.size(), 1U) << "as if a skin measured it";
  EXPECT_EQ(sample.reported[0].body, link);
  run(100);
  EXPECT_GT((loop.q() - before).norm(), 1e-3) << "the arm yields";
  loop.hold_push({});
  run(1);
  EXPECT_TRUE(sample.forces.empty());
  EXPECT_NE(message_of([&] { loop.hold_push({.body = 1000}); }).find("push.body"), std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
