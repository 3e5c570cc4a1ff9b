#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "geometry_msgs/msg/pose_stamped.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp_action/rclcpp_action.hpp"
#include "sensor_msgs/msg/joint_state.hpp"
#include "stiction/execution/closed_loop/run.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction_ros2/action/follow_contact_plan.hpp"
#include "stiction_ros2/ros_driver.hpp"
#include "trajectory_msgs/msg/joint_trajectory.hpp"

namespace stiction_ros2 {

/// The action `follow_contact_plan`: execution::run with a robot behind topics. One goal at a time.
///
///   joint_states             sensor_msgs/JointState          of all joints of the task's robots
///   objects/NAME             geometry_msgs/PoseStamped       of each object, in the world of the scene
///   joint_trajectory         trajectory_msgs/JointTrajectory one point after the other, for a joint_trajectory_controller
class FollowContactPlan {
 public:
  using Action = action::FollowContactPlan;
  using Handle = rclcpp_action::ServerGoalHandle<Action>;

  /// @throws core::InvalidInput: a parameter, the task
  explicit FollowContactPlan(rclcpp::Node::SharedPtr node);
  ~FollowContactPlan();
  FollowContactPlan(const FollowContactPlan&) = delete;
  FollowContactPlan& operator=(const FollowContactPlan&) = delete;

 private:
  void declare();
  void subscribe();
  rclcpp_action::GoalResponse ask(const Action::Goal& goal);
  void start(const std::shared_ptr<Handle>& handle);
  /// @throws core::InvalidInput: what the goal names
  void carry_out(const std::shared_ptr<Handle>& handle, Action::Result& result);
  void send(const Eigen::VectorXd& u, double period) const;

  const rclcpp::Node::SharedPtr node_;
  stiction::tasks::Task task_;
  std::unique_ptr<RosDriver> driver_;
  stiction::execution::RunOptions how_;
  std::atomic<bool> busy_{false}, stop_{false};
  std::thread worker_;
  rclcpp::Subscription<sensor_msgs::msg::JointState>::SharedPtr joint_states_;
  std::vector<rclcpp::Subscription<geometry_msgs::msg::PoseStamped>::SharedPtr> objects_;
  rclcpp::Publisher<trajectory_msgs::msg::JointTrajectory>::SharedPtr commands_;
  rclcpp_action::Server<Action>::SharedPtr server_;
};

}  // namespace stiction_ros2
