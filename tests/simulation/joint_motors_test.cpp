// Armature and damping of robot joints from MJCF, compared with MuJoCo's own simulation of the file.
#include <mujoco/mujoco.h>

#include <array>

#include "simulation/scenes.hpp"
#include "stiction/simulation/stepped_plant.hpp"
#include "world/mjcf_oracle.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::test::load_mujoco;
using world::test::Owned;
using world::test::write_mjcf;

/// A finger like those of metaworld: a small mass on a slide with the armature and damping of a large one.
std::filesystem::path finger(const std::string& joint, const std::string& actuator) {
  return write_mjcf(
      "<option timestep='0.0002' integrator='implicitfast' gravity='0 0 0'/><worldbody><body name='finger'>"
      "<joint name='x' type='slide' axis='1 0 0' " +
          joint +
          "/><geom type='box' size='.045 .003 .015' mass='0.1'/></body></worldbody>"
          "<actuator><position joint='x' kp='400' " +
          actuator + "/></actuator>",
      "finger.xml");
}

world::Scene scene_of(const std::filesystem::path& file) {
  world::Scene scene = empty_scene({0, 0, 0});
  world::RobotSpec robot;
  robot.name = "r";
  robot.mjcf = file;
  scene.robots.push_back(robot);
  return scene;
}

std::shared_ptr<const Plant> make_plant(const world::Scene& scene, bool effort_limits = false) {
  PlantOptions options;
  options.velocity_reference = true;
  options.effort_limits = effort_limits;
  return Plant::make(world::Model::make(scene), options);
}

/// A force of 5 N moves the finger by 12.5 mm in the end. With its damping this takes seconds, and without it a tenth of a second.
TEST(JointMotors, PushedFinger_MovesAsInMujoco) {
  const auto file = finger("armature='1' damping='400'", "kv='600'");
  const auto plant = make_plant(scene_of(file));
  EXPECT_EQ(plant->armature()[0], 1);
  EXPECT_EQ(plant->damping()[0], 600) << "k_v of the file, more than the 42 of critical damping";
  SteppedPlant ours(plant);
  int body = -1;
  for (std::size_t i = 0; i < plant->model().bodies().size(); ++i)
    if (plant->model().bodies()[i].name == "r/finger") body = static_cast<int>(i);
  ours.set_pushes(std::array{Push{body, Vector3d::Zero(), Vector3d(5, 0, 0)}});
  const Owned<mjModel> m = load_mujoco(file);
  const Owned<mjData> d(mj_makeData(m.get()));
  d->qfrc_applied[0] = 5;
  for (int k = 1; k <= 20; ++k) {
    ASSERT_EQ(ours.advance(VectorXd::Zero(1), 0.1), Status::Solved) << ours.message();
    for (int i = 0; i < 500; ++i) mj_step(m.get(), d.get());
    EXPECT_NEAR(ours.q()[0], d->qpos[0], 1e-6) << k;
  }
  EXPECT_LT(ours.q()[0], 0.008) << "after two seconds";
}

/// Two fingers like those of metaworld hold a cube of 0.75 kg with 8 N, and a force of 1.5 N pulls it towards one of them for 0.3 s, as when the hand
/// accelerates by 2 m/s². @returns the largest motion of the cube [m]
double swing(const std::string& joint) {
  const auto file =
      write_mjcf("<worldbody><body name='left' pos='-.03 0 0'><joint name='l' type='slide' axis='1 0 0' " + joint +
                     "/><geom type='box' size='.005 .02 .02' mass='0.016'/></body><body name='right' pos='.03 0 0'><joint name='r' "
                     "type='slide' axis='1 0 0' " +
                     joint +
                     "/><geom type='box' size='.005 .02 .02' mass='0.016'/></body></worldbody>"
                     "<actuator><position joint='l' kp='400'/><position joint='r' kp='400'/></actuator>",
                 "gripper.xml");
  world::Scene scene = scene_of(file);
  scene.objects.push_back(solid(world::ObjectJoint::Free, world::Box{{0.025, 0.02, 0.02}}, 0.75, 1));
  const auto plant = make_plant(scene);
  SteppedPlant stepped(plant);
  stepped.reset(plant->model().neutral(), Eigen::Vector2d(0, 0));
  EXPECT_EQ(stepped.advance(Eigen::Vector2d(0.02, -0.02), 0.5), Status::Solved);
  EXPECT_EQ(stepped.advance(Eigen::Vector2d(0.02, -0.02), 2), Status::Solved);
  const double start = stepped.q()[0];
  stepped.set_pushes(std::array{Push{plant->model().objects()[0].body, Vector3d::Zero(), Vector3d(1.5, 0, 0)}});
  double most = 0;
  for (int k = 0; k < 30; ++k) {
    EXPECT_EQ(stepped.advance(Eigen::Vector2d(0.02, -0.02), 0.01), Status::Solved);
    most = std::max(most, std::abs(stepped.q()[0] - start));
  }
  return most;
}

TEST(JointMotors, HeldCube_SwingsLessWithTheDampingOfItsFingers) {
  const double damped = swing("armature='100' damping='1000'"), free = swing("");
  EXPECT_LT(damped, 1e-3);
  EXPECT_GT(free, 1.8e-3) << "1.5 N on 800 N/m";
}

/// The servo overcomes the damping while the joint follows its command: the motion is that of a joint without damping.
TEST(JointMotors, FingerThatFollowsItsCommand_TrailsAsOneWithoutDamping) {
  const auto travel = [](const std::string& joint) {
    SteppedPlant plant(make_plant(scene_of(finger(joint, ""))));
    VectorXd out(10), u = VectorXd::Zero(1);
    for (int k = 0; k < 10; ++k) {
      u[0] += 0.01;
      EXPECT_EQ(plant.advance(u, 0.2), Status::Solved);
      out[k] = plant.q()[0];
    }
    return out;
  };
  const VectorXd damped = travel("armature='1' damping='400'"), free = travel("armature='1'");
  EXPECT_LT((damped - free).cwiseAbs().maxCoeff(), 3e-4);
  EXPECT_NEAR(damped[9], 0.1, 1e-3);
}

/// The motor gives what overcomes the damping: 20 N move the finger at 0.05 m/s.
TEST(JointMotors, MotorWithLittleForce_IsSlowedByTheDamping) {
  SteppedPlant plant(make_plant(scene_of(finger("armature='1' damping='400'", "forcelimited='true' forcerange='-20 20'")), true));
  VectorXd u = VectorXd::Zero(1);
  for (int k = 0; k < 10; ++k) {
    u[0] += 0.02;
    ASSERT_EQ(plant.advance(u, 0.1), Status::Solved);
  }
  EXPECT_NEAR(plant.v()[0], 0.05, 1e-3);
}

/// A spring without damping of its own asks for any speed towards its command.
TEST(JointMotors, UndampedServo_OvercomesTheDampingTowardsItsCommand) {
  const auto first_half = [](const std::string& joint) {
    PlantOptions options;
    options.damping_ratio = 0;
    SteppedPlant plant(Plant::make(world::Model::make(scene_of(finger(joint, ""))), options));
    plant.reset(VectorXd::Constant(1, -0.02), VectorXd::Zero(1));
    EXPECT_EQ(plant.advance(VectorXd::Zero(1), 0.05), Status::Solved);
    return plant.q()[0];
  };
  EXPECT_NEAR(first_half("armature='1' damping='40'"), first_half("armature='1'"), 2e-4);
}

/// A joint with the damping of a clamp stays stable, and moves where its command goes.
TEST(JointMotors, HugeDamping_IsStable) {
  SteppedPlant plant(make_plant(scene_of(finger("damping='1e11'", ""))));
  VectorXd u = VectorXd::Zero(1);
  for (int k = 0; k < 100; ++k) {
    u[0] += 0.001;
    ASSERT_EQ(plant.advance(u, 0.02), Status::Solved) << plant.message();
  }
  EXPECT_NEAR(plant.q()[0], 0.1, 2e-3);
}

}  // namespace
}  // namespace stiction::simulation::test
