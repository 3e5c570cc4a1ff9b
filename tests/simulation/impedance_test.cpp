#include "simulation/scenes.hpp"

#include "stiction/simulation/driven_plant.hpp"
#include "support/message_of.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kStiffness[] = {800, 600, 600, 600, 400, 200, 200};

std::shared_ptr<const world::Model> arm(double gravity) {
  world::Scene scene = empty_scene({0, 0, gravity});
  world::RobotSpec robot;
  robot.name = "arm";
  robot.urdf = source_dir() / "models" / "iiwa7_balls.urdf";
  for (int j = 0; j < 7; ++j) robot.stiffness.emplace_back("joint_" + std::to_string(j + 1), kStiffness[j]);
  scene.robots.push_back(robot);
  return world::Model::make(scene);
}

DrivenPlant drive(std::shared_ptr<const world::Model> model, const ImpedanceOptions& options = {}, double armature = 0) {
  PlantOptions plant;
  plant.damping_ratio = 0;
  plant.armature = armature;
  return DrivenPlant(Plant::make(std::move(model), plant), options);
}

VectorXd bent_posture() { return (VectorXd(7) << 0, 0, 0, -1.70, 0, 1.0, 0).finished(); }

/// K (q_end − q_0) = Jᵀ f after one second under a dead load.
TEST(Impedance, StaticLoad_IsBorneByTheSprings) {
  for (const double period : {2e-4, 1e-3}) {
    const auto model = arm(-10);
    DrivenPlant plant = drive(model, {.period = period});
    const VectorXd q0 = bent_posture();
    int link_7 = -1;
    for (std::size_t b = 0; b < model->bodies().size(); ++b)
      if (model->bodies()[b].name == "arm/link_7") link_7 = static_cast<int>(b);
    ASSERT_GE(link_7, 0);
    const Vector3d force(0, 0, -20);
    plant.reset(q0);
    plant.set_push({.body = link_7, .force_W = force});
    ASSERT_EQ(plant.advance(q0, 3.0), Status::Solved) << plant.message();

    world::KinematicsWorkspace work(*model);
    world::Kinematics kinematics;
    world::calc_kinematics(*model, plant.q(), work, kinematics);
    const Vector3d p = kinematics.X_WB[static_cast<std::size_t>(link_7)].p;
    double largest = 0;
    for (int j = 0; j < 7; ++j) {
      const double want = kinematics.axis_W.col(j).cross(p - kinematics.origin_W.col(j)).dot(force);
      EXPECT_NEAR(kStiffness[j] * (plant.q()[j] - q0[j]), want, 1e-5) << "joint " << j << ", period " << period;
      EXPECT_NEAR(plant.external()[j], want, 1e-9) << "joint " << j;
      largest = std::max(largest, std::abs(want));
    }
    EXPECT_GT(largest, 5) << "nothing was borne";
    EXPECT_LT(plant.v().cwiseAbs().maxCoeff(), 1e-4);
  }
}

/// A force on a link is the same force under the base, with its moment about W's origin, behind the lag of the observer.
TEST(DrivenPlant, WrenchAtTheBase_IsThatOfThePush) {
  const auto model = arm(-10);
  PlantOptions options;
  options.damping_ratio = 0;
  DrivenPlant plant(Plant::make(model, options), {.period = 2e-4}, ObserverOptions{.time_constant = 0.01, .noise = 0});
  const auto body = std::find_if(model->bodies().begin(), model->bodies().end(), [](const auto& b) { return b.name == "arm/link_6"; });
  const int link = static_cast<int>(body - model->bodies().begin());
  const Vector3d force(3, -7, -20), p_BP(0.02, 0, 0.05);
  plant.reset(bent_posture());
  plant.set_push({.body = link, .p_BP = p_BP, .force_W = force});
  ASSERT_EQ(plant.advance(bent_posture(), 2e-4), Status::Solved);
  EXPECT_LT((plant.base_wrench().head<3>() - 2e-4 / (0.01 + 2e-4) * force).norm(), 1e-9);
  ASSERT_EQ(plant.advance(bent_posture(), 3.0), Status::Solved);
  world::KinematicsWorkspace work(*model);
  world::Kinematics kinematics;
  world::calc_kinematics(*model, plant.q(), work, kinematics);
  EXPECT_LT((plant.base_wrench().head<3>() - force).norm(), 1e-9);
  EXPECT_LT((plant.base_wrench().tail<3>() - (kinematics.X_WB[static_cast<std::size_t>(link)] * p_BP).cross(force)).norm(), 1e-4);
  plant.set_push({});
  ASSERT_EQ(plant.advance(bent_posture(), 1.0), Status::Solved);
  EXPECT_LT(plant.base_wrench().norm(), 1e-6);
}

/// Gravity is compensated: without a load the arm stays where it is told to be.
TEST(Impedance, NoLoad_StaysAtTheCommand) {
  DrivenPlant plant = drive(arm(-9.81));
  plant.reset(bent_posture());
  ASSERT_EQ(plant.advance(bent_posture(), 1.0), Status::Solved);
  EXPECT_LT((plant.q() - bent_posture()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(plant.time(), 1.0, 1e-12);
}

/// One slider of 1 kg at 100 N/m: critically damped, (1 + ω t) e^{−ω t}.
TEST(Impedance, StepOfTheCommand_IsCriticallyDamped) {
  world::Scene scene = empty_scene({0, 0, -9.81});
  scene.robots.push_back(pusher(100));
  DrivenPlant plant = drive(world::Model::make(scene), {.velocity_cutoff = 1e5, .gain_cutoff = 1e5});
  plant.reset(VectorXd::Zero(2));
  const Eigen::Vector2d command(0.1, -0.2);
  for (int k = 1; k <= 50; ++k) {
    ASSERT_EQ(plant.advance(command, 0.01), Status::Solved);
    const double s = 10 * plant.time(), want = 1 - (1 + s) * std::exp(-s);
    EXPECT_NEAR(plant.q()[0], 0.1 * want, 1e-3 * 0.1) << "half a timestep late: ω h / 2 = 1e-3";
    EXPECT_NEAR(plant.q()[1], -0.2 * want, 1e-3 * 0.2);
  }
}

/// D = 2 √(K M_ii), with the mass matrix of tests/simulation/spring_test.cpp.
TEST(Impedance, Damping_IsCriticalForTheInertiaOfTheJoint) {
  const auto model = arm(-9.81);
  DrivenPlant plant = drive(model);
  plant.reset(model->neutral());
  ASSERT_EQ(plant.advance(model->neutral(), 2e-4), Status::Solved);
  const VectorXd want = Plant::make(model)->damping();
  EXPECT_LT((plant.damping() - want).cwiseQuotient(want).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Impedance, FiltersOfVelocityAndGain_HaveTheGainOfTheirCutoff) {
  const Eigen::VectorXd K = VectorXd::Constant(1, 100), zero = VectorXd::Zero(1), one = VectorXd::Ones(1);
  ImpedanceController controller(K, {.velocity_cutoff = 400, .gain_cutoff = 1, .period = 2e-4});
  (void)controller.update(zero, zero, zero, one);
  const double damping = controller.damping()[0];
  EXPECT_NEAR(damping, 20, 1e-12);  // 2 √(100 · 1)
  const double omega = 2 * 3.14159265358979323846, a_v = 2e-4 * 400 * omega / (1 + 2e-4 * 400 * omega),
               a_d = 2e-4 * omega / (1 + 2e-4 * omega);
  const double torque = controller.update(zero, one, zero, 4 * one)[0];
  const double damping_next = 20 + a_d * (40 - 20);
  EXPECT_NEAR(controller.damping()[0], damping_next, 1e-12);
  EXPECT_NEAR(torque, -damping_next * a_v, 1e-12);
}

TEST(DrivenPlant, SameCommands_GiveTheSameBits) {
  const auto model = arm(-9.81);
  VectorXd ends[2];
  DrivenPlant plant = drive(model);
  for (VectorXd& end : ends) {
    plant.reset(bent_posture());
    VectorXd command = bent_posture();
    for (int k = 0; k < 50; ++k) {
      command.array() += 1e-3;
      ASSERT_EQ(plant.advance(command, 0.005), Status::Solved);
    }
    end = plant.q();
  }
  EXPECT_EQ(ends[0], ends[1]);
}

TEST(DrivenPlant, BadInput_IsNamed) {
  const auto model = arm(-9.81);
  const auto message = [](auto&& call) { return stiction::test::message_of(call); };
  EXPECT_NE(message([&] { DrivenPlant(Plant::make(model, {}), {}); }).find("plant.damping_ratio"), std::string::npos);
  EXPECT_NE(message([&] { drive(model, {.period = 3e-4}); }).find("impedance.period: got 0.0003 s"), std::string::npos);
  EXPECT_NE(message([&] { drive(model, {.period = 0}); }).find("impedance.period: got 0"), std::string::npos);
  DrivenPlant plant = drive(model);
  EXPECT_NE(message([&] { (void)plant.advance(VectorXd::Zero(3), 0.1); }).find("command"), std::string::npos);
  EXPECT_NE(message([&] { (void)plant.advance(VectorXd::Zero(7), 0); }).find("duration: got 0"), std::string::npos);
  EXPECT_NE(message([&] { plant.set_push({.body = 1000}); }).find("push.body"), std::string::npos);
}

}  // namespace
}  // namespace stiction::simulation::test
