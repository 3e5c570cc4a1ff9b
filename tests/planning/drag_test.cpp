#include "stiction/planning/drag.hpp"

#include <gtest/gtest.h>

#include "world/test_scenes.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

constexpr double kSpeed = 0.0125, kStiffness = 100, kMass = 5;  // of planar_pushing [m/s], [N/m], [kg]

/// The pusher below the box of planar_pushing, which goes along the commands.
struct Pushing {
  Eigen::VectorXd go(double rest_time, const Eigen::MatrixXd& commands) {
    dynamics::StepOptions options;
    options.regularisation = dynamics::ByRule{1e-6};  // the box is held back by the drag alone
    Eigen::VectorXd q = q0, u = commands.col(0);
    EXPECT_EQ(Drag(*model, q0, rest_time).push(commands.rightCols(commands.cols() - 1), options, work, result, q, u, steps),
              Status::Solved);
    return q;
  }

  std::shared_ptr<const world::Model> model = world::test::load_task("planar_pushing");
  dynamics::StepWorkspace work{model};
  dynamics::StepResult result;
  Eigen::VectorXd q0 = (Eigen::VectorXd(5) << 0, 0.5, 0, 0, -0.1).finished();  // y, z, θ of the box; y, z of the pusher
  long steps = 0;
};

/// K (u − x) = D (x − x_before)/Δt at every command, and on through the pause of 4 s.
TEST(Drag, StraightPush_TrailsByTheLagOfTheDamping) {
  Pushing pushing;
  Eigen::MatrixXd commands = Eigen::MatrixXd::Zero(2, 21);
  for (int k = 0; k <= 20; ++k) commands(1, k) = -0.1 + 0.01 * k;
  for (const double rest_time : {0.05, 0.005}) {
    const double D = kMass / rest_time;
    double x = -0.1;
    const auto follow = [&](double u, double duration) { x = (kStiffness * u + D / duration * x) / (kStiffness + D / duration); };
    for (int k = 1; k <= 20; ++k) follow(commands(1, k), 0.01 / kSpeed);
    const double lag = 0.1 - x;
    for (int k = 0; k < 4; ++k) follow(0.1, 1.0);
    const Eigen::VectorXd q = pushing.go(rest_time, commands);
    EXPECT_GT(lag, 0.01);
    EXPECT_NEAR(q[4], x, 1e-5);
    EXPECT_NEAR(q[1], x + 0.6, 1e-5);
  }
  EXPECT_EQ(pushing.steps, 2 * 24);
}

/// A slider of 1 kg between two fingers that go 5 cm along it: it resists with 20 N s/m · 12.5 mm/s = 0.25 N. Friction of 0.5 N takes it along as the
/// quasi-static model says. Friction of 0.05 N does so in that model alone: the block slips until the drag is as small, and comes 0.05/0.25 of the way.
TEST(Drag, WeakGrip_LosesWhatItCarries) {
  world::Scene scene;
  scene.name = "grip";
  scene.gravity.setZero();
  scene.objects.push_back(world::test::make_object("block", world::ObjectJoint::Slider));
  auto& block = scene.objects[0];
  block.axis = Eigen::Vector3d::UnitZ();
  block.mass = 1;
  block.geometries = {{.name = "block", .shape = world::Box{Eigen::Vector3d(0.05, 0.02, 0.02)}, .X_BG = {}, .friction = 0.5}};
  world::RobotSpec robot;
  robot.name = "gripper";
  robot.urdf = world::test::source_dir() / "models" / "planar_gripper.urdf";
  robot.stiffness = {{"y", 1000}, {"x_left", 100}, {"x_right", 100}};
  robot.friction = 0.5;
  scene.robots.push_back(robot);
  const auto model = world::Model::make(scene);
  dynamics::StepWorkspace work(model);
  dynamics::StepResult result;
  const auto carried = [&](double squeeze, double rest_time) {
    Eigen::VectorXd q(4), u(3);
    q << 0, -0.1, -0.05, 0.05;  // fingers at the height of the block, on its sides
    u << -0.1, -0.05 + squeeze, 0.05 - squeeze;
    Eigen::MatrixXd commands = u.replicate(1, 200);
    commands.row(0) = Eigen::RowVectorXd::LinSpaced(200, -0.09975, -0.05);
    long steps = 0;
    EXPECT_EQ(Drag(*model, q, rest_time).push(commands, {}, work, result, q, u, steps), Status::Solved);
    return q[0];
  };
  for (const double squeeze : {5e-3, 5e-4}) EXPECT_NEAR(carried(squeeze, 1e6), 0.05, 5e-3) << squeeze;
  EXPECT_NEAR(carried(5e-3, 0.05), 0.05, 5e-3);
  EXPECT_NEAR(carried(5e-4, 0.05), 0.01, 2e-3);
}

TEST(Drag, ObjectsThatAreFree_HaveNone) {
  const auto model = world::test::load_task("allegro_ball");
  EXPECT_FALSE(Drag(*model, model->neutral(), 0.05).acts());
  const auto door = world::test::load_task("allegro_door");
  EXPECT_TRUE(Drag(*door, door->neutral(), 0.05).acts());
}

}  // namespace
}  // namespace stiction::planning::test
