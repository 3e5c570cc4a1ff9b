#include "stiction_ros2/bounded_force_controller.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "stiction/dynamics/step.hpp"
#include "stiction/world/scene.hpp"
#include "support/temporary_folder.hpp"

// Against stand-ins for ros2_control (stubs/), which have its signatures; ROS itself is not needed.

namespace stiction_ros2 {
namespace {

using controller_interface::CallbackReturn;
using controller_interface::return_type;
using namespace stiction;

/// An arm of two joints in the plane x-y, with a ball at its tip, beside a wall at y = 0.1 that the controller does not know of.
constexpr const char* kArm = R"(<robot name="arm">
  <link name="base"/>
  <link name="upper"><collision name="c"><origin xyz="0.25 0 0" rpy="0 1.5707963 0"/><geometry><cylinder radius="0.02" length="0.5"/></geometry></collision></link>
  <link name="tip"><collision name="ball"><origin xyz="0.4 0 0"/><geometry><sphere radius="0.03"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="100" velocity="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="tip"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="100" velocity="3"/></joint>
</robot>)";

/// Writes the arm, and makes the world in which it stands.
std::shared_ptr<const world::Model> make_world(const std::filesystem::path& folder) {
  std::ofstream(folder / "arm.urdf") << kArm;
  const std::string robot = "gravity: [0, 0, 0]\nrobots:\n  - {name: arm, urdf: arm.urdf, stiffness: 300, friction: 0.0}\n";
  std::ofstream(folder / "arm.yaml") << robot;
  std::ofstream(folder / "world.yaml")
      << robot << "fixed:\n  - {name: wall, pose: {position: [0.9, 0.2, 0]}, friction: 0.0, shapes: [{box: {size: [1, 0.2, 1]}}]}\n";
  return world::Model::make(world::load_scene(folder / "world.yaml"));
}

struct Rig {
  Rig() { node().parameters["scene"] = (folder.path() / "arm.yaml").string(); }
  rclcpp::Node& node() { return *controller.get_node(); }
  /// @returns what on_configure says, and the names that the controller wants
  CallbackReturn configure() {
    EXPECT_EQ(controller.on_init(), CallbackReturn::SUCCESS);
    return controller.on_configure({});
  }
  void activate() {
    controller.lend({&q[0], &q[1]}, {&command[0], &command[1]});
    ASSERT_EQ(controller.on_activate({}), CallbackReturn::SUCCESS);
  }
  /// A tick of the loop, and of the quasi-static arm at the wall. @returns the force of the wall [N]
  double tick(double shoulder, bool felt) {
    trajectory_msgs::msg::JointTrajectoryPoint reference;
    reference.positions = {shoulder, 0};
    node().deliver("~/reference", reference);
    EXPECT_EQ(controller.update(rclcpp::Time(now), rclcpp::Duration::from_seconds(kPeriod)), return_type::OK);
    Eigen::Map<Eigen::Vector2d> at(q.data());
    const Eigen::Vector2d commanded(command[0], command[1]);
    EXPECT_EQ(dynamics::step(*world_model, {at, commanded}, {.h = kPeriod}, work, step), core::Status::Solved);
    at = step.q_next;
    now += static_cast<std::int64_t>(1e9 * kPeriod);
    // The balance of the springs says how hard the wall pushes: torque of the shoulder over the lever of the ball.
    const Eigen::Vector2d torque = 300 * (commanded - at);
    const double lever = 0.5 * std::cos(q[0]) + 0.4 * std::cos(q[0] + q[1]), force = torque[0] / lever;
    if (felt) report(force);
    return force;
  }
  /// A force along -y of the world on the ball, in the frame of the tip and about its origin.
  void report(double force) {
    const double angle = q[0] + q[1];
    const Eigen::Vector3d f(-force * std::sin(angle), -force * std::cos(angle), 0), p(0.4, 0, 0), m = p.cross(f);
    geometry_msgs::msg::WrenchStamped message;
    message.header.frame_id = "tip";
    message.header.stamp.sec = static_cast<std::int32_t>(now / 1000000000);
    message.header.stamp.nanosec = static_cast<std::uint32_t>(now % 1000000000);
    message.wrench.force = {f.x(), f.y(), f.z()};
    message.wrench.torque = {m.x(), m.y(), m.z()};
    node().deliver("~/contacts", message);
  }

  static constexpr double kPeriod = 0.005;  // [s]
  stiction::test::TemporaryFolder folder;
  std::shared_ptr<const world::Model> world_model = make_world(folder.path());
  BoundedForceController controller;
  std::array<double, 2> q{0, 0}, command{0, 0};
  std::int64_t now = 1000000000;
  dynamics::StepWorkspace work{world_model};
  dynamics::StepResult step;
};

/// The reference of the shoulder goes 0.3 rad through the wall in 2 s, and stays.
double press(Rig& rig, bool felt) {
  double force = 0;
  for (int k = 0; k < 800; ++k) force = rig.tick(0.3 * std::min(1.0, k / 400.0), felt);
  return force;
}

TEST(BoundedForceController, AsksForThePositionsOfTheScenesJoints) {
  Rig rig;
  ASSERT_EQ(rig.configure(), CallbackReturn::SUCCESS);
  const std::vector<std::string> expected{"shoulder/position", "elbow/position"};
  EXPECT_EQ(rig.controller.command_interface_configuration().names, expected);
  EXPECT_EQ(rig.controller.state_interface_configuration().names, expected);
}

TEST(BoundedForceController, ThroughAWall_PressesWithItsBoundWhereItFeelsAndHarderWhereNot) {
  Rig bounded, blind;
  for (Rig* rig : {&bounded, &blind}) {
    ASSERT_EQ(rig->configure(), CallbackReturn::SUCCESS);
    rig->activate();
  }
  EXPECT_NEAR(press(bounded, true), 15, 0.5);
  EXPECT_GT(press(blind, false), 40);
}

TEST(BoundedForceController, WithoutAReference_StaysWhereItWasSwitchedOn) {
  Rig rig;
  ASSERT_EQ(rig.configure(), CallbackReturn::SUCCESS);
  rig.q = {-0.4, 0.2};
  rig.activate();
  for (int k = 0; k < 10; ++k)
    ASSERT_EQ(rig.controller.update(rclcpp::Time(rig.now + k * 5000000), rclcpp::Duration::from_seconds(0.005)), return_type::OK);
  EXPECT_NEAR(rig.command[0], -0.4, 1e-9);
  EXPECT_NEAR(rig.command[1], 0.2, 1e-9);
}

TEST(BoundedForceController, BadInput_IsSaidAndNotTaken) {
  Rig rig;
  rig.node().parameters["scene"] = std::string("none.yaml");
  EXPECT_EQ(rig.configure(), CallbackReturn::ERROR);
  ASSERT_FALSE(rig.node().logger.lines->empty());
  EXPECT_NE(rig.node().logger.lines->back().find("none.yaml"), std::string::npos);
  Rig other;
  ASSERT_EQ(other.configure(), CallbackReturn::SUCCESS);
  other.activate();
  trajectory_msgs::msg::JointTrajectoryPoint reference;
  reference.positions = {0.1};
  other.node().deliver("~/reference", reference);
  EXPECT_EQ(other.node().logger.lines->back(), "reference: got 1 positions, expected 2 finite ones; it is not taken");
}

TEST(ContactBook, WrenchOfAForce_IsAContactOnItsLineOfAction_UntilItIsOld) {
  Rig rig;
  const auto model = world::Model::make(world::load_scene(rig.folder.path() / "arm.yaml"));
  ContactBook book(*model, 0.1);
  const Eigen::Vector3d f(1, -7, 2), p(0.4, 0.03, -0.02);
  EXPECT_FALSE(book.take("thumb", 0, f, p.cross(f)));
  ASSERT_TRUE(book.take("arm/tip", 1.0, f, p.cross(f)));
  const Eigen::VectorXd q = Eigen::Vector2d(0.3, -0.5);
  const auto& contacts = book.contacts(1.05, q);
  ASSERT_EQ(contacts.size(), 1U);
  const auto pose = [&] {
    world::KinematicsWorkspace work(*model);
    world::Kinematics kinematics;
    calc_kinematics(*model, q, work, kinematics);
    return kinematics.X_WB[static_cast<std::size_t>(contacts[0].body)];
  }();
  EXPECT_LT((contacts[0].force_W - pose.R * f).norm(), 1e-12);
  const Eigen::Vector3d along = contacts[0].p_WC - (pose.p + pose.R * p);
  EXPECT_LT(along.cross(pose.R * f).norm(), 1e-12) << "on the line of action";
  EXPECT_TRUE(book.contacts(1.11, q).empty());
}

}  // namespace
}  // namespace stiction_ros2
