#include "stiction/planning/regrasp.hpp"

#include "planning/systems.hpp"
#include "stiction/contact/contact_sampler.hpp"
#include "stiction/world/scales.hpp"
#include "world/gripper.hpp"

namespace stiction::planning::test {
namespace {

TEST(TryRegrasp, AcceptedOnes_KeepTheObjectAtRest) {
  const auto model = load_model("allegro_ball");
  const PlannerOptions options;
  const Setting setting({.model = model, .q_start = allegro_start(), .goal = {}, .q_goal = {}}, options);
  const core::RunControl control;
  SimulationScratch scratch(model, control);
  const Eigen::VectorXd q = allegro_start();
  const Allowance& allowed = setting.thresholds.regrasp;
  RegraspCounts counts;
  for (int attempt = 0; attempt < 40; ++attempt) {
    core::Random random(9, static_cast<std::uint64_t>(attempt));
    Regrasp regrasp;
    if (!try_regrasp(setting, q, q.tail(16), {contact::draw_grasp(setting.chains, contact::GenericSampler{}, random), true}, {}, random,
                     scratch, regrasp, counts))
      continue;
    Eigen::VectorXd now = q;  // an own simulation of every knot
    dynamics::StepResult result;
    scratch.steps.forget();
    for (const auto& knot : regrasp.knots) {
      ASSERT_EQ(dynamics::step(*model, {now, knot.u}, setting.exact, scratch.steps, result), core::Status::Solved);
      now = result.q_next;
      EXPECT_LE(setting.goal.share(q, now, allowed.position + 1e-5, allowed.angle + 1e-4), 1);
    }
  }
  EXPECT_GT(counts.accepted, 10);
  EXPECT_EQ(counts.tried, 40);
  EXPECT_EQ(counts.accepted + counts.no_sample + counts.no_path + counts.object_moved + counts.failed_step, 40);
}

/// Four fingers leave a ball on a palm, where it stays as long as gravity is straight.
TEST(TryRegrasp, BallThatIsFreeToRoll_IsLeftAsTheLastResortOnly) {
  const auto model = load_model("allegro_ball");
  const PlannerOptions options;
  const Setting setting{{.model = model, .q_start = model->neutral(), .goal = {}, .q_goal = {}}, options};
  const core::RunControl control;
  SimulationScratch scratch{model, control};
  const Eigen::VectorXd q = allegro_start();
  for (const bool last_resort : {false, true}) {
    RegraspCounts counts;
    for (int attempt = 0; attempt < 10; ++attempt) {
      core::Random random(3, static_cast<std::uint64_t>(attempt));
      Regrasp regrasp;
      try_regrasp(setting, q, q.tail(16), {setting.chains.all(), last_resort}, {}, random, scratch, regrasp, counts);
      EXPECT_TRUE(regrasp.unstable);
    }
    EXPECT_EQ(counts.accepted > 0, last_resort);
  }
}

/// Regrasps of the planar hand at its start.
struct HandRegrasps {
  explicit HandRegrasps(const std::string& task = "planar_hand") : model(load_model(task)) {}

  std::shared_ptr<const world::Model> model;
  PlannerOptions options = hand_options();
  Setting setting{{.model = model, .q_start = model->neutral(), .goal = {}, .q_goal = {}}, options};
  core::RunControl control;
  SimulationScratch scratch{model, control};
  Eigen::VectorXd q = hand_problem().q_start;

  bool attempt(const GraspJudge& judge, core::Random& random, Regrasp& out, RegraspCounts& counts) {
    const world::ChainMask draw = contact::draw_grasp(setting.chains, contact::GenericSampler{}, random);
    return try_regrasp(setting, q, q.tail(4), {draw}, judge, random, scratch, out, counts);
  }
};

TEST(FreeOnItsWay, TouchOnTheWayCountsAtItsEndsNot) {
  HandRegrasps hand;
  core::Random random(4, 0);
  const world::ChainMask draw{hand.setting.chains.all()};
  const auto sample =
      contact::sample_contact(*hand.model, hand.setting.chains, contact::GenericSampler{}, draw, hand.q, random, hand.scratch.geometry);
  ASSERT_TRUE(sample);
  const auto at = [&](double share) {  // of the way from the start, which is free, to the contact sample
    dynamics::Knot knot;
    knot.q = hand.q;
    knot.q.tail(4) += share * (sample->q_a - hand.q.tail(4));
    return knot;
  };
  ASSERT_GT((sample->q_a - hand.q.tail(4)).cwiseAbs().maxCoeff(), 0.2);
  const auto is_free = [&](const std::vector<double>& shares) {
    std::vector<dynamics::Knot> knots;
    for (const double share : shares) knots.push_back(at(share));
    return is_free_on_its_way(*hand.model, hand.setting.chains, knots, hand.scratch.geometry);
  };
  EXPECT_TRUE(is_free({0, 0.5, 1.05})) << "into contact";
  EXPECT_TRUE(is_free({1.05, 0.5, 0, 0.5, 1.05})) << "out of it and back";
  EXPECT_FALSE(is_free({0, 0.5, 1.05, 0.5})) << "touches on its way";
  EXPECT_FALSE(is_free({1.05, 1.6, 1.05})) << "never free";
  EXPECT_TRUE(is_free({1.05, 1.06, 1.05})) << "stays where it is";
}

/// A ball that only goes up and down: a finger that presses from the side, off its centre, lets it slide away, a step at a time.
TEST(TryRegrasp, AcceptedOnes_HoldTheObjectForAsLongAsCommandsRest) {
  HandRegrasps hand("planar_hand_fixed_y");
  hand.q = (Eigen::VectorXd(6) << 0.35, 0, hand_problem().q_start.tail(4)).finished();
  const Allowance& rest = hand.setting.thresholds.rest;  // in a step, when it was taken to rest
  RegraspCounts counts;
  for (int attempt = 0; attempt < 100; ++attempt) {
    core::Random random(13, static_cast<std::uint64_t>(attempt));
    Regrasp regrasp;
    if (!hand.attempt({}, random, regrasp, counts)) continue;
    Eigen::VectorXd now = regrasp.knots.back().q;
    dynamics::StepResult result;
    hand.scratch.steps.forget();
    for (int k = 0; k < 100; ++k) {
      ASSERT_EQ(dynamics::step(*hand.model, {now, regrasp.knots.back().u}, {}, hand.scratch.steps, result), core::Status::Solved);
      EXPECT_LE(hand.setting.goal.share(now, result.q_next, 2 * rest.position, 2 * rest.angle), 1) << attempt << ", step " << k;
      now = result.q_next;
    }
  }
  EXPECT_GT(counts.accepted, 10);
}

/// Postures promise more the later they were drawn, and the simulated ones of those that promise most turn out in the opposite order.
TEST(TryRegrasp, Trials_TakeWhatWasSimulatedBestOfThoseThatPromiseMost) {
  HandRegrasps hand;
  RegraspCounts counts;
  int best_taken = 0;
  for (int attempt = 0; attempt < 40; ++attempt) {
    core::Random random(12, static_cast<std::uint64_t>(attempt));
    std::vector<Eigen::VectorXd> drawn, simulated;
    const auto command = [&](std::size_t i) { return Eigen::VectorXd::Constant(4, static_cast<double>(i)); };
    GraspJudge judge;
    judge.promise = [&](const Eigen::VectorXd& q, const Eigen::VectorXd& holding) -> Promise {
      EXPECT_EQ(holding, q.tail(4)) << "fingers that touch from one side press nothing";
      drawn.emplace_back(q.tail(4));
      return {-static_cast<double>(drawn.size()), command(drawn.size())};
    };
    judge.simulated = [&](const Eigen::VectorXd& q, const Eigen::VectorXd&, const Eigen::VectorXd& u) {
      simulated.emplace_back(q.tail(4));
      EXPECT_EQ(u, command(drawn.size() + 1 - simulated.size())) << "that of the promise";
      return -static_cast<double>(simulated.size());
    };
    Regrasp regrasp;
    const bool held = hand.attempt(judge, random, regrasp, counts);
    ASSERT_EQ(simulated.size(), std::min<std::size_t>(threshold::kTrials, drawn.size()));
    for (std::size_t i = 0; i < simulated.size(); ++i) EXPECT_EQ(simulated[i], drawn[drawn.size() - 1 - i]);
    if (!held || simulated.size() < threshold::kTrials) continue;
    best_taken += (regrasp.knots.back().u - simulated.back()).norm() < 1e-9;
  }
  EXPECT_GT(counts.accepted, 10);
  EXPECT_GT(best_taken, counts.accepted * 3 / 4) << "the others had no path";
}

/// The cube weighs as much as friction holds with 1 N at each finger, and fingers that only touch it leave it on the ground.
TEST(TryRegrasp, AGripperThatCloses_CanLift) {
  const world::test::RobotFolder folder;
  const auto model = world::test::make_gripper(folder, 0.2);
  const PlannerOptions options;
  const Eigen::VectorXd q = world::test::gripper_start(*model);
  const Setting setting{{.model = model, .q_start = q, .goal = {}, .q_goal = {}}, options};
  const core::RunControl control;
  SimulationScratch scratch{model, control};
  const auto lift = [&](Eigen::VectorXd at, Eigen::VectorXd u) {
    dynamics::StepResult result;
    scratch.steps.forget();
    for (int k = 0; k < 50; ++k) {
      u[2] += 1e-3;
      EXPECT_EQ(dynamics::step(*model, {at, u}, setting.exact, scratch.steps, result), core::Status::Solved);
      at = result.q_next;
    }
    return at[2] - q[2];
  };
  GraspJudge judge;
  judge.sampler.pinch_probability = 1;
  RegraspCounts counts;
  int lifted = 0, by_touch = 0;
  for (int attempt = 0; attempt < 20; ++attempt) {
    core::Random random(7, static_cast<std::uint64_t>(attempt));
    Regrasp regrasp;
    if (!try_regrasp(setting, q, q.tail(7), {setting.chains.all(), true}, judge, random, scratch, regrasp, counts)) continue;
    const dynamics::Knot& end = regrasp.knots.back();
    lifted += lift(end.q, end.u) > 0.045;
    by_touch += lift(end.q, end.q.tail(7)) > 0.045;
  }
  EXPECT_GT(counts.accepted, 5);
  EXPECT_GT(lifted, counts.accepted / 2);
  EXPECT_EQ(by_touch, 0);
}

}  // namespace
}  // namespace stiction::planning::test
