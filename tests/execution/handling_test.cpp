#include "stiction/execution/closed_loop/handling.hpp"

#include <gtest/gtest.h>

#include "simulation/scenes.hpp"

namespace stiction::execution::test {
namespace {

using Eigen::VectorXd;

constexpr double kRadius = 0.05, kGravity = 9.81;

/// A free ball of 0.2 kg over the ground, and a robot out of its way.
struct BallAndPusher {
  std::shared_ptr<const world::Model> model;
  VectorXd q;

  explicit BallAndPusher(double height) {
    world::Scene scene = simulation::test::empty_scene({0, 0, -kGravity});
    scene.objects.push_back(simulation::test::solid(world::ObjectJoint::Free, world::Sphere{kRadius}, 0.2, 1));
    scene.fixed.push_back(simulation::test::ground(1));
    scene.robots.push_back(simulation::test::pusher(100));
    model = world::Model::make(scene);
    q = model->neutral();
    q[2] = kRadius + height;
    q.tail(2) << -2, 1;
  }
};

TEST(Handling, BallThatLies_IsPressedWithItsWeight) {
  BallAndPusher rig(0);
  for (const double mass : {1.0, 3.0}) {
    SimulatedPlant plant(rig.model, rig.q, {.mass = mass});
    const VectorXd u = plant.world().u();
    while (plant.world().time() < 0.5) ASSERT_TRUE(plant.command(u, 1e-3));
    ASSERT_TRUE(plant.largest_press());
    EXPECT_NEAR(*plant.largest_press(), 1, 0.1) << mass;
  }
}

/// Speed g t of a ball that falls, as a slip where it was to stay, and none where it was to fall.
TEST(Handling, SlipSpeedIsWhatTheObjectIsFasterThanPlanned) {
  for (const bool planned : {false, true}) {
    BallAndPusher rig(1);
    SimulatedPlant plant(rig.model, rig.q);
    HandlingWatch watch(plant);
    const VectorXd u = plant.world().u();
    const auto look = [&](int piece) {
      const VectorXd q = plant.world().q();
      watch.take({.time = plant.world().time(),
                  .state = planned ? RunState::Push : RunState::Hold,
                  .q = q,
                  .q_plan = planned ? q : rig.q,
                  .u = u,
                  .piece = piece});
    };
    look(-1);
    for (const int piece : {-1, 0, 1}) {
      for (int k = 0; k < 5; ++k) {
        ASSERT_TRUE(plant.command(u, 0.02));
        look(piece);
      }
    }
    const Handling handling = watch.result();
    ASSERT_EQ(handling.slip_speeds.size(), 2U);
    const double slow = planned ? kGravity * 0.01 : kGravity * 0.2, fast = planned ? kGravity * 0.01 : kGravity * 0.3;
    EXPECT_NEAR(handling.slip_speeds[0], slow, 0.02) << "planned speeds are means over 0.02 s";
    EXPECT_NEAR(handling.slip_speeds[1], fast, 0.02);
    EXPECT_EQ(handling.slip_speed(), std::max(handling.slip_speeds[0], handling.slip_speeds[1]));
  }
}

TEST(Handling, WithoutAFreeObjectThereIsNoForce) {
  const auto model = simulation::test::load_task("planar_pushing");
  SimulatedPlant plant(model, (VectorXd(5) << 0, 0.6, 0, 0, -0.02).finished());
  HandlingWatch watch(plant);
  EXPECT_FALSE(watch.result().force);
  EXPECT_EQ(watch.result().slip_speed(), 0);
}

}  // namespace
}  // namespace stiction::execution::test
