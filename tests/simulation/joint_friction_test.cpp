// Hinges and sliders with dry and viscous friction: the numbers of the quasi-static model, with inertia.
#include "simulation/scenes.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::ObjectJoint;

/// A valve about x whose weight of 2 kg pulls at 0.1 m: 1.962 N·m.
world::Scene valve(double friction, double damping = 0) {
  world::Scene scene = empty_scene({0, 0, -9.81});
  world::ObjectSpec object = solid(ObjectJoint::Hinge, world::Sphere{0.05}, 2, 0.5);
  object.axis = Vector3d::UnitX();
  object.p_BCom = object.geometries[0].X_BG.p = {0, 0.1, 0};
  object.joint_friction = friction;
  object.joint_damping = damping;
  scene.objects.push_back(object);
  return scene;
}

TEST(JointFriction, ValveThatIsLeftAlone_StaysForFourSeconds) {
  Rig rig(valve(2.0));
  ASSERT_EQ(rig.hold(VectorXd::Zero(1), VectorXd(0), 4.0), Status::Solved) << rig.result.message;
  EXPECT_LT(std::abs(rig.q_end()[0]), 1e-3);
  Rig loose(valve(1.9));
  ASSERT_EQ(loose.hold(VectorXd::Zero(1), VectorXd(0), 1.0), Status::Solved);
  EXPECT_LT(loose.q_end()[0], -0.05) << "it begins to turn";
}

/// I a = m g sin α − τ_f of a drawer.
TEST(JointFriction, DrawerOnSlope_AcceleratesByWhatItsWeightExceedsItsFriction) {
  const double alpha = 0.4;
  world::Scene scene = empty_scene({0, 0, -9.81});
  world::ObjectSpec drawer = solid(ObjectJoint::Slider, world::Box{{0.1, 0.1, 0.05}}, 2, 0.5);
  drawer.axis = {0, std::cos(alpha), -std::sin(alpha)};
  drawer.joint_friction = 5;
  scene.objects.push_back(drawer);
  Rig rig(scene);
  ASSERT_EQ(rig.hold(VectorXd::Zero(1), VectorXd(0), 0.5), Status::Solved);
  const double a = 9.81 * std::sin(alpha) - 5.0 / 2;
  EXPECT_NEAR(rig.q_end()[0], a * 0.25 / 2, 2e-3 * a * 0.25 / 2);
}

/// A load of 1.9 N·m beyond nothing: ω = load/D after a while.
TEST(JointFriction, Damping_SpeedIsLoadOverIt) {
  world::Scene scene = valve(0, 40);
  Rig rig(scene);
  ASSERT_EQ(rig.hold(VectorXd::Zero(1), VectorXd(0), 0.05), Status::Solved);
  EXPECT_NEAR(rig.v_end()[0], -2 * 9.81 * 0.1 / 40, 1e-4);
}

/// In free flight, speeds decay as exp(−D t/m) and exp(−D t/I).
TEST(JointFriction, DampingOfAFreeObject_SlowsItsMotionAndItsTurning) {
  world::Scene scene = empty_scene(Vector3d::Zero());
  world::ObjectSpec ball = solid(ObjectJoint::Free, world::Sphere{0.1}, 2, 0.5);
  ball.joint_damping = 0.04;
  scene.objects.push_back(ball);
  Rig rig(scene);
  VectorXd v0(6);
  v0 << 0.3, 0, 0, 0, 2, 0;
  constexpr double kTime = 0.5;
  ASSERT_EQ(rig.hold(rig.model->neutral(), VectorXd(0), kTime, &v0), Status::Solved) << rig.result.message;
  EXPECT_NEAR(rig.v_end()[0], 0.3 * std::exp(-0.04 / 2 * kTime), 1e-5);
  EXPECT_NEAR(rig.v_end()[4], 2 * std::exp(-0.04 / ball.inertia(1, 1) * kTime), 1e-2);
}

/// A latch on a spring rests where its weight and the spring balance: k (q₀ − q) = m g r cos q.
TEST(JointSpring, ValveOnASpring_HangsWhereItBalancesItsWeight) {
  world::Scene scene = valve(0, 0.5);
  scene.objects[0].joint_stiffness = 10;
  scene.objects[0].joint_rest = 0.3;
  Rig rig(scene);
  ASSERT_EQ(rig.hold(VectorXd::Zero(1), VectorXd(0), 3.0), Status::Solved);
  const double q = rig.q_end()[0];
  EXPECT_NEAR(10 * (0.3 - q), 2 * 9.81 * 0.1 * std::cos(q), 1e-4);
}

/// Dry friction of a robot joint: its servo overcomes it unless it is asked for.
TEST(JointFriction, OfRobotJoints_ActsWhenAskedFor) {
  for (const bool asked : {false, true}) {
    world::Scene scene = empty_scene(Vector3d::Zero());
    scene.robots.push_back(pusher(100));
    std::string text =
        R"(<robot name="p"><link name="a"/><link name="b"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <joint name="y" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="100" velocity="1"/>
      <dynamics friction="3"/></joint></robot>)";
    scene.robots[0].urdf = source_dir() / "";
    scene.robots[0].text = text;
    scene.robots[0].stiffness = {{"y", 100}};
    PlantOptions options;
    options.joint_friction = asked;
    Rig rig(scene, options);
    ASSERT_EQ(rig.hold(VectorXd::Zero(1), VectorXd::Constant(1, 0.02), 2.0), Status::Solved) << rig.result.message;
    EXPECT_NEAR(rig.q_end()[0], asked ? 0 : 0.02, 1e-4) << "2 N of the spring against 3 N";
  }
}

}  // namespace
}  // namespace stiction::simulation::test
