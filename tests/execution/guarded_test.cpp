// Moves that end where something is felt: distances along a direction, what torques tell of a touch, and whole runs in the simulation.
#include "stiction/execution/touch/guarded_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "execution/touch_options.hpp"
#include "stiction/core/random.hpp"
#include "stiction/execution/touch/approach.hpp"
#include "stiction/execution/touch/feeler.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/tasks/touch_scenario_file.hpp"
#include "support/message_of.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using stiction::test::message_of;
using stiction::test::source_dir;
using tasks::load_touch_scenario;

std::filesystem::path file_of(const char* name) { return source_dir() / "scenarios" / (std::string(name) + ".yaml"); }
TouchScenario load(const char* name) { return load_touch_scenario(file_of(name)); }

int body_of(const world::Model& model, const std::string& name) {
  for (std::size_t b = 0; b < model.bodies().size(); ++b)
    if (model.bodies()[b].name == name) return static_cast<int>(b);
  return -1;
}

class Approach : public testing::Test {
 protected:
  TouchScenario scenario = load("lower_until_touch");
  const world::Model& model = *scenario.arm.model;
  int hand = body_of(model, "arm/link_7"), table = body_of(model, "table");
  VectorXd q = sensing::place_robots(model, scenario.arm.start);
  double radius = 0.031, height = 0;  ///< of the hand's ball; of its lowest point above the table

  void SetUp() override {
    world::KinematicsWorkspace work(model);
    world::Kinematics kinematics;
    world::calc_kinematics(model, q, work, kinematics);
    const Vector3d centre = kinematics.X_WB[static_cast<std::size_t>(hand)] * Vector3d(0, 0, 0.06);
    height = centre.z() - radius - 0.3;
  }
};

TEST_F(Approach, BallAboveATable_GoesDownByItsHeightLessTheGap) {
  EXPECT_NEAR(calc_approach(model, q, hand, table, -Vector3d::UnitZ(), 0).value(), height, 1e-6);
  EXPECT_NEAR(calc_approach(model, q, hand, table, -Vector3d::UnitZ(), 0.01).value(), height - 0.01, 1e-6);
  EXPECT_NEAR(calc_approach(model, q, hand, table, -Vector3d::UnitZ(), height + 0.02).value(), -0.02, 1e-6) << "back";
}

TEST_F(Approach, SlantedDirection_IsLongerByItsSlant) {
  const Vector3d slanted = Vector3d(0.1, 0, -1).normalized();
  EXPECT_NEAR(calc_approach(model, q, hand, table, slanted, 0).value(), height / -slanted.z(), 1e-6);
}

TEST_F(Approach, LinkThatIsMovedBeyondAnEdge_ComesBackToTheEdge) {
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  const double y = (kinematics.X_WB[static_cast<std::size_t>(hand)] * Vector3d(0, 0, 0.06)).y(), edge = 0.4;
  // The ball's lowest point is below the table's top by 10 mm: it touches the edge with its centre beyond by √(r² − (r − 0.01)²).
  world::Scene scene = model.scene();
  scene.fixed.front().X_WB.p.z() += height + 0.01;
  const auto higher = world::Model::make(scene);
  const double beyond = std::sqrt(radius * radius - (radius - 0.01) * (radius - 0.01));
  EXPECT_NEAR(calc_approach(*higher, q, hand, table, -Vector3d::UnitY(), 0, -1).value(), -(edge + beyond - y), 1e-5);
}

TEST_F(Approach, DirectionThatDoesNotLeadThere_HasNone) {
  EXPECT_FALSE(calc_approach(model, q, hand, table, Vector3d::UnitZ(), 0));
  EXPECT_FALSE(calc_approach(model, q, hand, table, Vector3d::UnitX(), 0));
}

/// Rows of a momentum observer that knows the torques `tau`, with the noise and the lag that the scenario states.
class Observer {
 public:
  explicit Observer(const ControlScenario& arm, std::uint64_t seed)
      : memory_(std::exp(-arm.period / arm.observer.time_constant)),
        white_(arm.observer.joint_noise * std::sqrt((1 + memory_) / (1 - memory_))),
        random_(seed, 7),
        row_(VectorXd::Zero(arm.model->n_a())) {}
  const VectorXd& next(const VectorXd& tau) {
    for (Eigen::Index j = 0; j < row_.size(); ++j) row_[j] = memory_ * row_[j] + (1 - memory_) * (tau[j] + white_[j] * random_.normal());
    return row_;
  }

 private:
  double memory_;
  VectorXd white_;
  core::Random random_;
  VectorXd row_;
};

const Vector3d kInwards = Vector3d(-1, 0, -1).normalized();  ///< of the push on the hand's ball, in its frame

class Feeling : public testing::Test {
 protected:
  TouchScenario scenario = load("lower_until_touch");
  const world::Model& model = *scenario.arm.model;
  VectorXd rest = VectorXd::LinSpaced(7, -0.4, 0.3);
  Feeler feeler{scenario.arm};

  void start(Observer& observer) {
    for (int k = 0; k < 50; ++k) (void)observer.next(rest);  // its lag
    feeler.listen();
    for (int k = 0; k < 100; ++k) EXPECT_FALSE(feeler.update(observer.next(rest), scenario.arm.start));
    feeler.start();
  }
  VectorXd push(double newtons) {
    const VectorXd q = sensing::place_robots(model, scenario.arm.start);
    return sensing::calc_contact_torque(model, q, body_of(model, "arm/link_7"), Vector3d(0, 0, 0.06) - 0.031 * kInwards,
                                        newtons * kInwards);
  }
};

TEST_F(Feeling, NothingIsFeltAtRestForTwoMinutes) {
  Observer observer(scenario.arm, 1);
  start(observer);
  int alarms = 0;
  for (int k = 0; k < 24000; ++k) alarms += feeler.update(observer.next(rest), scenario.arm.start);
  EXPECT_EQ(alarms, 0) << "rows of an observer depend on each other: what takes them for white alarms";
}

TEST_F(Feeling, PushOnTheHand_IsNoticedWithin25MillisecondsAndIsOnTheHandWithItsForce) {
  Observer observer(scenario.arm, 2);
  start(observer);
  const VectorXd tau = rest + push(3);
  int rows = 1;
  while (!feeler.update(observer.next(tau), scenario.arm.start) && rows < 1000) ++rows;
  EXPECT_LE(rows * scenario.arm.period, 0.025);
  EXPECT_LE(feeler.age(), 0.03);
  feeler.settle();
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(feeler.update(observer.next(tau), scenario.arm.start));
  const sensing::SenseResult& sensed = feeler.identify(scenario.arm.start);
  const int hand = feeler.sensor().link_index("arm/link_7");
  EXPECT_GT(sensed.posterior.links[static_cast<std::size_t>(hand)], 0.5);
  ASSERT_FALSE(sensed.candidates.empty());
  double force = 0;
  for (const auto& c : sensed.candidates)
    if (c.best.link == hand) force = std::max(force, c.f_W.norm());
  EXPECT_NEAR(force, 3, 0.3);
}

TEST_F(Feeling, WithoutRowsAtRest_SaysSo) {
  EXPECT_NE(message_of([&] { feeler.start(); }).find("rest: got no row"), std::string::npos);
  EXPECT_NE(message_of([&] { (void)feeler.identify(scenario.arm.start); }).find("touch: got nothing"), std::string::npos);
}

class Lowering : public testing::TestWithParam<std::uint64_t> {};

TEST_P(Lowering, FindsTheTableAndGoesOnFromThere) {
  const TouchScenario scenario = load("lower_until_touch");
  GuardedRunResult out;
  ASSERT_EQ(run_guarded(scenario, with_seed(GetParam()), out), Status::Solved) << out.reason;
  ASSERT_TRUE(out.reached) << out.reason;
  ASSERT_EQ(out.moves.size(), scenario.moves.size());
  const auto height = [](const world::Model& model) { return model.scene().fixed.front().X_WB.p.z(); };
  EXPECT_GT(std::abs(height(*out.world) - height(*scenario.arm.model)), 3e-3) << "the height was right: the test would say nothing";
  EXPECT_NEAR(height(*out.model), height(*out.world), 3e-3);
  for (const std::size_t k : {0u, 4u}) {
    const MoveResult& move = out.moves[k];
    EXPECT_EQ(move.outcome, MoveOutcome::Felt);
    ASSERT_EQ(move.felt.size(), 1u);
    EXPECT_EQ(scenario.arm.model->bodies()[static_cast<std::size_t>(move.felt[0].body)].name, "arm/link_7");
    EXPECT_GT(move.felt[0].direction_W.z(), 0.9);
    EXPECT_NEAR(move.felt[0].force, 5, 1);
    EXPECT_NEAR(move.last_force, 5, 1);
    EXPECT_LE(move.late_peak, 1.2 * 5);
    EXPECT_LT(std::abs(move.correction_error.value()), 3e-3);
  }
  EXPECT_NEAR(out.moves[4].travelled, 0.01, 2e-3) << "'near' stopped 10 mm above where the table is";
  EXPECT_EQ(out.moves[3].peak, 0);
}
INSTANTIATE_TEST_SUITE_P(Seeds, Lowering, testing::Values(1, 2));

TEST(GuardedRun, ButtonIsPressedWithItsForce) {
  GuardedRunResult out;
  ASSERT_EQ(run_guarded(load("press_button"), with_seed(3), out), Status::Solved) << out.reason;
  ASSERT_TRUE(out.reached) << out.reason;
  EXPECT_NEAR(out.moves[0].last_force, 5, 1);
  EXPECT_LE(out.moves[0].late_peak, 6);
}

TEST(GuardedRun, WallIsFollowedToItsEdge) {
  const TouchScenario scenario = load("follow_wall");
  GuardedRunResult out;
  ASSERT_EQ(run_guarded(scenario, with_seed(1), out), Status::Solved) << out.reason;
  ASSERT_TRUE(out.reached) << out.reason;
  EXPECT_EQ(out.moves[1].outcome, MoveOutcome::Lost);
  EXPECT_LE(out.moves[1].late_peak, 1.2 * scenario.arm.controller.lambda_max);
  const auto place = [](const world::Model& model) -> Vector3d { return model.scene().fixed.front().X_WB.p; };
  EXPECT_GT(std::abs(place(*out.world).y() - place(*scenario.arm.model).y()), 3e-3) << "the edge was right: the test would say nothing";
  EXPECT_LT((place(*out.world) - place(*out.model)).norm(), 3e-3);
}

TEST(GuardedRun, WallWithoutAnEdgeWithinReach_IsSaid) {
  TouchScenario scenario = load("follow_wall");
  scenario.moves[1].travel = 0.02;
  GuardedRunResult out;
  ASSERT_EQ(run_guarded(scenario, with_seed(1), out), Status::Solved) << out.reason;
  EXPECT_FALSE(out.reached);
  EXPECT_EQ(out.moves.back().outcome, MoveOutcome::StillThere);
  EXPECT_NE(out.reason.find("still something to press on"), std::string::npos) << out.reason;
}

TEST(GuardedRun, HandClosesUntilBothSidesTouch) {
  const TouchScenario scenario = load("close_hand");
  for (const std::uint64_t seed : {2u, 4u}) {
    GuardedRunResult out;
    ASSERT_EQ(run_guarded(scenario, with_seed(seed), out), Status::Solved) << out.reason;
    ASSERT_TRUE(out.reached) << out.reason;
    const MoveResult& move = out.moves[0];
    EXPECT_EQ(move.outcome, MoveOutcome::Felt);
    ASSERT_EQ(move.felt.size(), 2u);
    for (const FeltContact& felt : move.felt) EXPECT_NEAR(felt.force, 5, 0.5);
    EXPECT_GT(std::abs(move.felt[0].alarm - move.felt[1].alarm), 0.5) << "the block was in the middle: the test would say nothing";
    EXPECT_LT(move.felt[0].direction_W.x(), -0.99) << "the left finger is pushed outwards";
    EXPECT_GT(move.felt[1].direction_W.x(), 0.99);
    EXPECT_LE(move.late_peak, 1.2 * 5);
    EXPECT_NEAR(move.last_force, 5, 1);
  }
}

TEST(GuardedRun, HandThatClosesOnNothing_SaysWhichSideFeltNothing) {
  TouchScenario scenario = load("close_hand");
  scenario.moves.front().posture[2] = 0.05;
  GuardedRunResult out;
  ASSERT_EQ(run_guarded(scenario, with_seed(1), out), Status::Solved);
  EXPECT_FALSE(out.reached);
  EXPECT_EQ(out.reason, "close: 'hand/right' felt nothing");
}

/// A side is what joints of its own move: of two links of one finger the outer one has, the inner one has not.
TEST(GuardedRun, LinksWithoutJointsOfTheirOwn_AreRefused) {
  TouchScenario scenario = load("close_hand");
  scenario.moves.front().until->links.push_back(body_of(*scenario.arm.model, "hand/palm"));
  GuardedRunResult out;
  const std::string message = message_of([&] { (void)run_guarded(scenario, with_seed(1), out); });
  EXPECT_NE(message.find("until.links: got 'hand/palm', expected links that joints of their own move"), std::string::npos) << message;
}

TEST(GuardedRun, NothingInTheWay_IsSaid) {
  TouchScenario scenario = load("lower_until_touch");
  scenario.moves.front().travel = 0.005;
  GuardedRunResult out;
  ASSERT_EQ(run_guarded(scenario, with_seed(1), out), Status::Solved);
  EXPECT_FALSE(out.reached);
  ASSERT_EQ(out.moves.size(), 1u);
  EXPECT_EQ(out.moves[0].outcome, MoveOutcome::NotFelt);
  EXPECT_EQ(out.reason, "lower: nothing was felt within 0.005 m");
  EXPECT_NEAR(out.moves[0].travelled, 0.005, 1e-3);
}

TEST(GuardedRun, TouchOnAnotherLink_EndsTheMove) {
  TouchScenario scenario = load("lower_until_touch");
  scenario.moves.front().until->links = {body_of(*scenario.arm.model, "arm/link_4")};
  GuardedRunResult out;
  ASSERT_EQ(run_guarded(scenario, with_seed(1), out), Status::Solved);
  EXPECT_FALSE(out.reached);
  EXPECT_EQ(out.moves[0].outcome, MoveOutcome::WrongLink);
  EXPECT_NE(out.reason.find("touched at 'arm/link_7'"), std::string::npos) << out.reason;
  EXPECT_LE(out.moves[0].late_peak, 6);
}

TEST(GuardedScenarioFile, BadInput_NamesFileAndField) {
  std::ifstream in(file_of("lower_until_touch"));
  std::string good((std::istreambuf_iterator<char>(in)), {});
  const std::string relative = "../models";
  good.replace(good.find(relative), relative.size(), (source_dir() / "models").string());
  const std::filesystem::path file = stiction::test::folder_of_the_process() / "guarded_test_bad.yaml";
  const auto message = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(file) << text;
    const std::string out = message_of([&] { (void)load_touch_scenario(file); });
    std::filesystem::remove(file);
    EXPECT_NE(out.find("guarded_test_bad.yaml"), std::string::npos) << out;
    return out;
  };
  EXPECT_NE(message("force: 5", "force: 7").find("moves[0].until.force: got 7, expected at most controller.lambda_max, 6 N"),
            std::string::npos);
  EXPECT_NE(message("{body: table, position", "{body: tabel, position").find("misplaced[0].body"), std::string::npos);
  EXPECT_NE(message("links: [arm/link_7]", "links: [arm/link_9]").find("moves[0].until.links[0]"), std::string::npos);
  EXPECT_NE(message("direction: [0, 0, -1]", "direction: [0, 0, 0]").find("moves[0].direction"), std::string::npos);
  EXPECT_NE(message("gap: {body: table", "press: {body: table").find("press"), std::string::npos);
  EXPECT_NE(message("start:", "goal: [0, 0.6, 0, -1.4, 0, 1.1, 0]\nstart:").find("one of goal, moves"), std::string::npos);
  EXPECT_NE(message("noise: [0.0538,", "noise: [0,").find("estimator.noise"), std::string::npos);
  EXPECT_NE(message("drift: [0,", "drift: [-1,").find("drift"), std::string::npos);
}

TEST(GuardedRun, ScenarioOfMoves_HasNoGoalForATouchRun) {
  TouchRunResult out;
  EXPECT_NE(message_of([&] { (void)run_touch(load("lower_until_touch"), {}, out); }).find("goal: got a scenario of moves"),
            std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
