#include "stiction/simulation/momentum_observer.hpp"

#include "simulation/scenes.hpp"
#include "stiction/simulation/driven_plant.hpp"
#include "support/message_of.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::VectorXd;

DrivenPlant arm(const ObserverOptions& observer) {
  world::Scene scene = empty_scene({0, 0, -9.81});
  world::RobotSpec robot;
  robot.name = "arm";
  robot.urdf = source_dir() / "models" / "iiwa7_balls.urdf";
  for (int j = 0; j < 7; ++j) robot.stiffness.emplace_back("joint_" + std::to_string(j + 1), 400);
  scene.robots.push_back(robot);
  PlantOptions plant;
  plant.damping_ratio = 0;
  return DrivenPlant(Plant::make(world::Model::make(scene), plant), {}, observer);
}

VectorXd turned_posture() { return (VectorXd(7) << 0.3, 0.4, -0.2, -1.70, 0.1, 1.0, 0).finished(); }

/// r of a moving arm is the first-order low-pass of what acts on it; MuJoCo's own sum of forces is the oracle.
TEST(MomentumObserver, PushedArmThatMoves_IsTheLowPassOfTheExternalTorque) {
  const ObserverOptions options{.time_constant = 0.02, .noise = 0};
  DrivenPlant plant = arm(options);
  plant.reset(turned_posture());
  constexpr double h = 2e-4;
  VectorXd want = VectorXd::Zero(7), command = turned_posture();
  const int last = static_cast<int>(plant.plant().model().bodies().size()) - 1;
  plant.set_push({.body = last, .force_W = {10, -20, 15}});
  double largest = 0, speed = 0;
  for (int k = 0; k < 2500; ++k) {
    command.array() += 2e-4;  // 1 rad/s: Coriolis and centrifugal torques matter
    ASSERT_EQ(plant.advance(command, h), Status::Solved);
    EXPECT_LT((plant.observed() - want).cwiseAbs().maxCoeff(), 0.02) << "tick " << k;
    want += h / (h + options.time_constant) * (plant.external() - want);
    largest = std::max(largest, want.cwiseAbs().maxCoeff()), speed = std::max(speed, plant.v().norm());
  }
  EXPECT_GT(largest, 5);
  EXPECT_GT(speed, 1);
}

/// A slider that moves on its spring at 0.5 m/s with 3 N of dry friction and 2 N s/m: to an observer that knows of none both are external, and what one knows it
/// takes off.
TEST(MomentumObserver, FrictionOfAJoint_IsExternalUnlessItIsKnown) {
  world::Scene scene = empty_scene({0, 0, 0});
  scene.robots.push_back(pusher(400));
  scene.robots[0].urdf = source_dir() / "";
  scene.robots[0].text =
      R"(<robot name="p"><link name="a"/><link name="b"><inertial><mass value="1"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <joint name="y" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="100" velocity="1"/>
      <dynamics friction="3" damping="2"/></joint></robot>)";
  scene.robots[0].stiffness = {{"y", 400}};
  const auto settled = [&](bool has_friction, std::optional<double> error) {
    PlantOptions options;
    options.damping_ratio = 0;
    options.joint_friction = has_friction;
    ObserverOptions observer{.time_constant = 0.01, .noise = 0};
    observer.friction_error = error;
    DrivenPlant plant(Plant::make(world::Model::make(scene), options), {}, observer);
    VectorXd command = VectorXd::Zero(1);
    plant.reset(command);
    for (int k = 0; k < 400; ++k) {
      command[0] += 0.5 * 5e-3;
      EXPECT_EQ(plant.advance(command, 5e-3), Status::Solved) << plant.message();
    }
    EXPECT_NEAR(plant.v()[0], 0.5, 0.01);
    return plant.observed()[0];
  };
  const double friction = 3 + 2 * 0.5;
  EXPECT_NEAR(settled(false, {}), 0, 0.02);
  EXPECT_NEAR(settled(true, {}), -friction, 0.1);
  EXPECT_NEAR(settled(true, 0.0), 0, 0.1);
  EXPECT_NEAR(settled(true, 0.25), 0.25 * friction, 0.1);
}

TEST(MomentumObserver, WhiteNoise_HasTheDeviationThatWasAskedFor) {
  MomentumObserver observer(1, 2e-4, {.time_constant = 0.01, .noise = 0.1, .seed = 3});
  const VectorXd zero = VectorXd::Zero(1);
  double sum = 0, squares = 0;
  constexpr int kSamples = 400000;
  for (int k = 0; k < kSamples; ++k) {
    const double r = observer.update(zero, zero, zero, zero)[0];
    sum += r, squares += r * r;
  }
  EXPECT_NEAR(std::sqrt(squares / kSamples), 0.1, 0.005) << "8000 time constants: 1 % of deviation";
  EXPECT_NEAR(sum / kSamples, 0, 0.01);
}

TEST(MomentumObserver, NoiseOfEachJoint_IsItsOwn) {
  const VectorXd noise = (VectorXd(2) << 0.1, 0.01).finished(), zero = VectorXd::Zero(2);
  MomentumObserver observer(2, 2e-4, {.time_constant = 0.01, .noise = 5, .seed = 3, .joint_noise = noise});
  VectorXd squares = zero;
  constexpr int kSamples = 400000;
  for (int k = 0; k < kSamples; ++k) squares += observer.update(zero, zero, zero, zero).cwiseAbs2() / kSamples;
  EXPECT_LT((squares.cwiseSqrt() - noise).cwiseQuotient(noise).cwiseAbs().maxCoeff(), 0.05);
}

/// A random walk of 4000 observers over a second: its deviation is the drift, with 1.1 % of error.
TEST(MomentumObserver, Drift_GrowsWithTheRootOfTime) {
  constexpr int kSeeds = 4000, kSteps = 100;
  const VectorXd drift = VectorXd::Constant(1, 0.3), zero = VectorXd::Zero(1);
  double half = 0, whole = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    MomentumObserver observer(1, 0.01, {.time_constant = 1e-9, .noise = 0, .seed = seed, .drift = drift});
    for (int k = 1; k <= kSteps; ++k) {
      const double r = observer.update(zero, zero, zero, zero)[0];
      if (k == kSteps / 4) half += r * r / kSeeds;
      if (k == kSteps) whole += r * r / kSeeds;
    }
  }
  EXPECT_NEAR(std::sqrt(whole), 0.3, 0.015);
  EXPECT_NEAR(std::sqrt(half), 0.15, 0.0075);
}

TEST(MomentumObserver, NothingActs_ShowsWeightOfWrongMassesAndBias) {
  const auto rest = [](const ObserverOptions& options) {
    DrivenPlant plant = arm(options);
    plant.reset(turned_posture());
    EXPECT_EQ(plant.advance(turned_posture(), 0.2), Status::Solved);
    return plant.observed();
  };
  EXPECT_LT(rest({.noise = 0}).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT(rest({.noise = 0, .inertia_error = 0.05}).cwiseAbs().maxCoeff(), 0.5);
  const VectorXd bias = rest({.noise = 0, .bias = 0.3, .seed = 1});
  EXPECT_GT(bias.cwiseAbs().minCoeff(), 0);
  EXPECT_LT(bias.norm(), 0.3 * 5);
}

/// Offsets of many sensors: as large on the average in every turned_posture, alike where postures are, independent far away.
TEST(MomentumObserver, OffsetsThatDependOnPosture_ChangeOverTheirReach) {
  constexpr double kBias = 1.5, kReach = 0.5;
  double at_0 = 0, at_far = 0, near = 0, far = 0;
  constexpr int kSeeds = 4000;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto offset = [&](double q) {
      MomentumObserver observer(1, 1, {.time_constant = 1e-9, .noise = 0, .bias = kBias, .bias_reach = kReach, .seed = seed});
      const VectorXd zero = VectorXd::Zero(1);
      return observer.update(zero, zero, zero, VectorXd::Constant(1, q))[0];
    };
    const double a = offset(0), b = offset(0.1 * kReach), c = offset(10 * kReach);
    at_0 += a * a / kSeeds, at_far += c * c / kSeeds, near += (a - b) * (a - b) / kSeeds, far += a * c / kSeeds;
  }
  // Deviation of a mean of squares of normal numbers: √(2/4000) = 2.2 % of it, of a correlation √(1/4000) = 1.6 %; four of them.
  EXPECT_NEAR(at_0 / (kBias * kBias), 1, 0.09);
  EXPECT_NEAR(at_far / (kBias * kBias), 1, 0.09);
  EXPECT_NEAR(near / (0.01 * kBias * kBias), 1, 0.15) << "E[(b(q) − b(q + d))²] = 2 b² (1 − exp(−d²/2 reach²)), fourth moments of w";
  EXPECT_NEAR(far / (kBias * kBias), 0, 0.07);
}

TEST(MomentumObserver, BadInput_IsNamed) {
  const auto message = [](const ObserverOptions& o) { return stiction::test::message_of([&] { o.validate(); }); };
  EXPECT_NE(message({.time_constant = 0}).find("observer.time_constant"), std::string::npos);
  EXPECT_NE(message({.noise = -1}).find("observer.noise"), std::string::npos);
  EXPECT_NE(message({.bias = -1}).find("observer.bias"), std::string::npos);
  EXPECT_NE(message({.bias_reach = -1}).find("observer.bias_reach"), std::string::npos);
  EXPECT_NE(message({.inertia_error = -1}).find("observer.inertia_error"), std::string::npos);
}

}  // namespace
}  // namespace stiction::simulation::test
