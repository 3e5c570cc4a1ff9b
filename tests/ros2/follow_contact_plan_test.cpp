#include "stiction_ros2/follow_contact_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/closed_loop/simulated_plant.hpp"

// Against stand-ins for ROS 2 (stubs/), which have its signatures. The robot behind the topics is a simulated one.

namespace stiction_ros2 {
namespace {

using namespace stiction;
using Action = action::FollowContactPlan;

builtin_interfaces::msg::Time stamp(double seconds) {
  return {static_cast<std::int32_t>(seconds), static_cast<std::uint32_t>(std::llround(1e9 * (seconds - std::floor(seconds))))};
}

/// A hand and a cube in MuJoCo, whose time goes on while somebody sleeps by its clock.
class Robot {
 public:
  Robot(rclcpp::Node& node, const tasks::Task& task) : node_(node), task_(task), plant_(task.model, task.problem.q_start) {
    node.clock->sleep = [this](double period) {
      go_on(period);
      return true;
    };
    node.sinks["joint_trajectory"] =
        std::function<void(const trajectory_msgs::msg::JointTrajectory&)>([this](const trajectory_msgs::msg::JointTrajectory& message) {
          EXPECT_EQ(message.joint_names.size(), static_cast<std::size_t>(task_.model->n_a()));
          const auto& positions = message.points.at(0).positions;
          u_ = Eigen::Map<const Eigen::VectorXd>(positions.data(), static_cast<Eigen::Index>(positions.size()));
        });
    execution::Measurement now;
    EXPECT_TRUE(plant_.read(now));
    u_ = now.u;
    tell();
  }
  bool silent = false;

 private:
  void go_on(double period) {
    EXPECT_TRUE(plant_.command(u_, period));
    if (!silent) tell();
  }
  void tell() {
    execution::Measurement now;
    ASSERT_TRUE(plant_.read(now));
    sensor_msgs::msg::JointState joints;
    joints.header.stamp = stamp(now.time);
    for (int j = task_.model->n_a() - 1; j >= 0; --j) {  // in another order than that of the model
      const std::string& name = task_.model->dofs()[static_cast<std::size_t>(task_.model->n_vu() + j)].name;
      joints.name.push_back(name.substr(name.find('/') + 1));
      joints.position.push_back(now.q[task_.model->n_qu() + j]);
    }
    const world::Pose X = world::object_pose(*task_.model, now.q, 0);
    const Eigen::Quaterniond q(X.R);
    geometry_msgs::msg::PoseStamped cube;
    cube.header.stamp = stamp(now.object_time);
    cube.pose = {{X.p.x(), X.p.y(), X.p.z()}, {q.x(), q.y(), q.z(), q.w()}};
    node_.deliver("objects/cube", cube);
    node_.deliver("joint_states", joints);
  }

  rclcpp::Node& node_;
  const tasks::Task& task_;
  execution::SimulatedPlant plant_;
  Eigen::VectorXd u_;
};

struct Rig {
  Rig() {
    node->parameters["task"] = std::string("allegro_cube");
    node->parameters["timeout"] = 0.3;
    server = std::make_unique<FollowContactPlan>(node);
    actions = std::any_cast<rclcpp_action::Server<Action>::SharedPtr>(node->topics.at("action:follow_contact_plan"));
    robot = std::make_unique<Robot>(*node, task);
  }
  /// The cube where it is, turned about the vertical.
  Action::Goal turned(double angle) const {
    const world::Pose X = world::object_pose(*task.model, task.problem.q_start, 0);
    const Eigen::Vector3d rpy = planning::roll_pitch_yaw(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * X.R);
    return {"", {X.p.x(), X.p.y(), X.p.z(), rpy[0], rpy[1], rpy[2]}, 60};
  }
  rclcpp::Node::SharedPtr node = std::make_shared<rclcpp::Node>("stiction");
  tasks::Task task = tasks::load_task("allegro_cube");
  std::unique_ptr<FollowContactPlan> server;
  rclcpp_action::Server<Action>::SharedPtr actions;
  std::unique_ptr<Robot> robot;
};

TEST(FollowContactPlan, TurnsACubeBehindTopics_AndTellsOnTheWay) {
  Rig rig;
  const auto handle = rig.actions->ask(rig.turned(0.3));
  ASSERT_NE(handle, nullptr);
  EXPECT_EQ(rig.actions->ask(rig.turned(0.3)), nullptr) << "one goal at a time";
  const Action::Result result = handle->wait();
  EXPECT_EQ(handle->how, "succeeded") << result.message;
  EXPECT_TRUE(result.reached);
  EXPECT_LT(result.angle_error, rig.task.problem.goal.tol_angle);
  EXPECT_GE(result.plans, 1U);
  ASSERT_GT(handle->feedback.size(), 10U);
  EXPECT_GT(handle->feedback.front().goal_share, 2) << "it began away from the goal";
  EXPECT_LT(handle->feedback.back().goal_share, 1);
}

TEST(FollowContactPlan, RobotThatFallsSilent_EndsTheGoalAndIsNamed) {
  Rig rig;
  rig.robot->silent = true;
  const auto handle = rig.actions->ask(rig.turned(0.3));
  ASSERT_NE(handle, nullptr);
  const Action::Result result = handle->wait();
  EXPECT_EQ(handle->how, "aborted");
  EXPECT_FALSE(result.reached);
  EXPECT_NE(result.message.find("nothing new of joint_0"), std::string::npos) << result.message;
}

TEST(FollowContactPlan, CancelledGoal_EndsCancelled) {
  Rig rig;
  const auto handle = rig.actions->ask(rig.turned(3.1));
  ASSERT_NE(handle, nullptr);
  handle->canceling = true;
  (void)handle->wait();
  EXPECT_EQ(handle->how, "canceled");
}

TEST(FollowContactPlan, BadGoal_IsRefusedInWords_AndTheNextOneIsTaken) {
  Rig rig;
  for (const Action::Goal& goal : {Action::Goal{"", {1, 2}, 0}, Action::Goal{"none.json", {}, 0}}) {
    const auto handle = rig.actions->ask(goal);
    ASSERT_NE(handle, nullptr);
    const Action::Result result = handle->wait();
    EXPECT_EQ(handle->how, "aborted");
    EXPECT_NE(result.message.find(goal.plan.empty() ? "got 2" : "none.json"), std::string::npos) << result.message;
  }
}

TEST(RosDriver, ObjectOnAJoint_IsRefused) {
  const tasks::Task task = tasks::load_task("planar_pushing");
  EXPECT_THROW(RosDriver(task.model, {}, 0.1), core::InvalidInput);
}

TEST(RosDriver, MeasurementIsHandedOutOnce_AndIsAsOldAsItsOldestPart) {
  const tasks::Task task = tasks::load_task("allegro_ball");
  RosDriver driver(task.model, {}, 0.02);
  execution::Measurement out;
  EXPECT_FALSE(driver.read(out));
  EXPECT_NE(driver.message().find("ball"), std::string::npos);
  EXPECT_FALSE(driver.take_object("cube", 1, {}));
  ASSERT_TRUE(driver.take_object("ball", 1.5, {Eigen::Matrix3d::Identity(), {0.1, 0.2, 0.3}}));
  const std::vector<double> joints(16, 0.25);
  driver.take_joints(2.0, driver.joints(), joints);
  ASSERT_TRUE(driver.read(out));
  EXPECT_EQ(out.time, 2.0);
  EXPECT_EQ(out.object_time, 1.5);
  EXPECT_EQ(out.q.head<3>(), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(out.q.tail<16>(), Eigen::VectorXd::Constant(16, 0.25));
  EXPECT_EQ(out.u, Eigen::VectorXd::Constant(16, 0.25)) << "joints are commanded where they are until there is a command";
  EXPECT_FALSE(driver.read(out)) << "nothing new";
}

}  // namespace
}  // namespace stiction_ros2
