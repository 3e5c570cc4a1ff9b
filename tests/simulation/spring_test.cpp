#include "simulation/scenes.hpp"
#include "stiction/core/random.hpp"
#include "stiction/simulation/stepped_plant.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Robots are gravity compensated: without contact a joint ends at its command, whatever gravity is.
TEST(Spring, NoContact_EndsAtTheCommand) {
  auto model = load_task("allegro_ball");
  Rig rig(model);
  Eigen::VectorXd q0 = model->neutral();
  q0[2] = 5;  // the ball falls far away
  const Eigen::VectorXd u = Eigen::VectorXd::Constant(16, 0.3);
  ASSERT_EQ(rig.hold(q0, u, 0.9), Status::Solved) << rig.result.message;
  for (int j = 0; j < 16; ++j) {
    const double reachable = std::clamp(u[j], model->lower()[j], model->upper()[j]);
    EXPECT_NEAR(rig.q_end().tail(16)[j], reachable, reachable == u[j] ? 1e-6 : 1e-2) << model->dofs()[static_cast<std::size_t>(6 + j)].name;
  }
  EXPECT_LT(rig.v_end().tail(16).norm(), 1e-5);
}

constexpr double kFine = 5e-5;  // timestep [s]

/// 1 kg on springs of 100 N/m.
Rig make_fine_pusher() {
  world::Scene scene = empty_scene({0, 0, -9.81});
  scene.robots.push_back(pusher(100));
  PlantOptions options;
  options.timestep = kFine;
  return Rig(scene, options);
}

TEST(Spring, StepOfTheCommand_IsCriticallyDamped) {
  Rig rig = make_fine_pusher();
  ASSERT_EQ(rig.hold(Vector2d(0, 0), Vector2d(0.1, -0.2), 1.0), Status::Solved);
  const double omega = 10;  // √(100 N/m / 1 kg)
  for (std::size_t k = 0; k < rig.result.times.size(); ++k) {
    const double s = omega * rig.result.times[k];
    const double want = 1 - (1 + s) * std::exp(-s);
    EXPECT_NEAR(rig.result.q(0, static_cast<Eigen::Index>(k)), 0.1 * want, 2e-4 * 0.1) << "first-order integrator: error ~ ω h";
    EXPECT_NEAR(rig.result.q(1, static_cast<Eigen::Index>(k)), -0.2 * want, 2e-4 * 0.2);
  }
  EXPECT_NEAR(rig.plant->damping()[0], 20, 1e-3);
}

/// The motor of a critically damped spring that steps by A gives K A (1 − ωt) exp(−ωt), at first K A and less and less; samples keep the largest since the one before.
TEST(Spring, StepOfTheCommand_TorqueHasItsPeaks) {
  Rig rig = make_fine_pusher();
  const Vector2d q(0, 0), u(0.1, -0.2);
  ASSERT_EQ(rig.hold(q, u, 1.0), Status::Solved);
  ASSERT_EQ(rig.result.torque.cols(), static_cast<Eigen::Index>(rig.result.times.size()));
  double before = -kFine;
  for (std::size_t k = 0; k < rig.result.times.size(); ++k) {
    double want = 0;
    for (double t = before + kFine; t < rig.result.times[k] + 0.5 * kFine; t += kFine) {
      const double now = 10 * (1 - 10 * t) * std::exp(-10 * t);
      if (std::abs(now) > std::abs(want)) want = now;
    }
    before = rig.result.times[k];
    EXPECT_NEAR(rig.result.torque(0, static_cast<Eigen::Index>(k)), want, 1e-3 * 10) << "first-order integrator";
    EXPECT_NEAR(rig.result.torque(1, static_cast<Eigen::Index>(k)), -2 * want, 2e-3 * 10);
  }

  SteppedPlant stepped(rig.plant);
  stepped.reset(q, u);
  ASSERT_EQ(stepped.advance(u, 0.1), Status::Solved);
  EXPECT_NEAR(stepped.take_torques()[0], 10, 1e-9);
  EXPECT_EQ(stepped.take_torques(), Eigen::VectorXd::Zero(2)) << "taken once";
  ASSERT_EQ(stepped.advance(u, 0.3), Status::Solved);
  EXPECT_NEAR(stepped.take_torques()[0], -10 * std::exp(-2.0), 1e-2) << "at ωt = 2";
}

/// D = 2 √(K I), with I from the mass matrix of MuJoCo: an oracle of calc_joint_inertia.
TEST(Spring, Damping_IsCriticalForTheInertiaOfTheJoint) {
  for (const char* task : {"planar_hand", "allegro_ball", "iiwa_bimanual", "ur5_mesh_push"}) {
    const auto model = load_task(task);
    const auto plant = Plant::make(model);
    world::KinematicsWorkspace work(*model);
    world::Kinematics kinematics;
    world::calc_kinematics(*model, model->neutral(), work, kinematics);
    const Eigen::VectorXd inertia = world::calc_joint_inertia(*model, kinematics);
    for (int j = 0; j < model->n_a(); ++j) {
      const double want = plant->damping()[j] * plant->damping()[j] / (4 * model->stiffness()[j]) - plant->armature()[j];
      EXPECT_NEAR(inertia[j], want, 1e-6 * want + 1e-12) << task << ", joint " << j;
    }
  }
}

/// Damped for the inertia at zero, where it stands upright, it would swing by half of the step.
TEST(Spring, StretchedArm_DoesNotSwing) {
  const auto model = load_task("iiwa_bimanual");
  SteppedPlant plant(Plant::make(model));
  Eigen::VectorXd q = model->neutral();
  q[model->n_qu() + 1] = q[model->n_qu() + 8] = M_PI / 2;
  Eigen::VectorXd u = q.tail(model->n_a());
  plant.reset(q, u);
  constexpr double kStep = 0.1;  // [rad]
  u[0] += kStep;
  double farthest = 0;
  for (int k = 0; k < 300; ++k) {
    ASSERT_EQ(plant.advance(u, 0.01), Status::Solved) << plant.message();
    farthest = std::max(farthest, plant.q()[model->n_qu()]);
  }
  EXPECT_LT(farthest, 1.02 * kStep);
  EXPECT_NEAR(plant.q()[model->n_qu()], kStep, 0.01 * kStep) << "not slow either";
}

/// An iiwa stands upright at zero, where hardly anything resists the joint that turns it about itself.
TEST(Spring, LargestInertia_IsThatOfNoPostureAlone) {
  const auto model = load_task("iiwa_bimanual");
  const Eigen::VectorXd largest = world::calc_largest_joint_inertia(*model);
  world::KinematicsWorkspace work(*model);
  world::Kinematics kinematics;
  Eigen::VectorXd q = model->neutral();
  world::calc_kinematics(*model, q, work, kinematics);
  EXPECT_GT(largest[0], 10 * world::calc_joint_inertia(*model, kinematics)[0]);
  core::Random random(3, 1);
  for (int k = 0; k < 50; ++k) {
    for (int j = 0; j < model->n_a(); ++j) q[model->n_qu() + j] = random.uniform(model->lower()[j], model->upper()[j]);
    world::calc_kinematics(*model, q, work, kinematics);
    EXPECT_LT(world::calc_joint_inertia(*model, kinematics).cwiseQuotient(largest).maxCoeff(), 1.1);
  }
}

TEST(Spring, AgainstWall_PushesWithStiffnessTimesDeflection) {
  for (const double stiffness : {100.0, 2000.0}) {
    world::Scene scene = empty_scene({0, 0, -9.81});
    scene.robots.push_back(pusher(stiffness));
    world::Pose X_WB{Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()).toRotationMatrix(), {0, 0.15, 0}};  // faces −y
    scene.fixed.push_back(ground(0.5, X_WB));
    Rig rig(scene);
    ASSERT_EQ(rig.hold(Vector2d(0, 0), Vector2d(0.2, 0), 3.0), Status::Solved);
    const double deflection = 0.2 - rig.q_end()[0];
    EXPECT_NEAR(deflection, 0.15, 1e-4);
    EXPECT_NEAR(rig.force().normal, stiffness * deflection, 1e-5 * stiffness * deflection);
    EXPECT_NEAR(rig.force().force_W.y(), -rig.force().normal, 1e-9 * stiffness);
  }
}

/// A motor that bears less than the wall would take: 15 N of spring, 6 N of motor.
TEST(Spring, EffortLimits_MotorPushesWithItsEffort) {
  for (const bool limited : {false, true}) {
    world::Scene scene = empty_scene({0, 0, -9.81});
    scene.robots.push_back(pusher(100));
    scene.robots[0].effort = {{"y", 6}};
    world::Pose X_WB{Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()).toRotationMatrix(), {0, 0.15, 0}};  // faces −y
    scene.fixed.push_back(ground(0.5, X_WB));
    PlantOptions options;
    options.effort_limits = limited;
    Rig rig(scene, options);
    ASSERT_EQ(rig.hold(Vector2d(0, 0), Vector2d(0.2, 0), 3.0), Status::Solved);
    EXPECT_NEAR(rig.force().normal, limited ? 6 : 15, 0.02);
  }
}

TEST(Spring, JointLimit_IsKept) {
  auto model = load_task("planar_hand");
  Rig rig(model);
  Eigen::VectorXd q0 = model->neutral();
  q0.head<3>() << 0, 5, 0;
  const Eigen::Vector4d u(0.5, 0.5, -0.5, -0.5);  // 0.5 rad beyond the limits at 0
  ASSERT_EQ(rig.hold(q0, u, 2.0), Status::Solved);
  for (int j = 0; j < 4; ++j) EXPECT_NEAR(rig.q_end().tail(4)[j], 0, 2e-3);
}

/// Knots are followed linearly: a spring of high stiffness shows the command itself.
TEST(Spring, KnotsOfTheCommand_AreInterpolated) {
  world::Scene scene = empty_scene(Vector3d::Zero());
  scene.robots.push_back(pusher(1e4));
  Rig rig(scene);
  Eigen::MatrixXd u(2, 4);
  u << 0, 0, 0.3, 0.3, 0, -0.1, -0.1, -0.1;
  const Eigen::Vector4d times(0, 0.5, 1.5, 2.5);
  ASSERT_EQ(simulate(*rig.plant, {Vector2d(0, 0), times, u}, rig.run, rig.work, rig.result), Status::Solved);
  const auto at = [&](double t) { return Vector2d(rig.result.q.col(std::lround(t / 0.01))); };
  const double lag = 2 / 100.0;  // of a critically damped spring behind a ramp: 2/ω
  EXPECT_LT((at(0.3) - Vector2d(0, -0.2 * (0.3 - lag))).norm(), 1e-4);
  EXPECT_LT((at(1.0) - Vector2d(0.3 * (0.5 - lag), -0.1)).norm(), 1e-4);
  EXPECT_LT((at(2.5) - Vector2d(0.3, -0.1)).norm(), 1e-6);
  EXPECT_NEAR(rig.result.times.back(), 2.5, 1e-12);
}

}  // namespace
}  // namespace stiction::simulation::test
