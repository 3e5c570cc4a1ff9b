#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "controller_interface/controller_interface.hpp"
#include "geometry_msgs/msg/wrench_stamped.hpp"
#include "rclcpp/rclcpp.hpp"
#include "realtime_tools/realtime_buffer.hpp"
#include "stiction_ros2/contact_book.hpp"
#include "trajectory_msgs/msg/joint_trajectory_point.hpp"

namespace stiction_ros2 {

/// control::ContactController as a plugin of ros2_control. It reads and commands the position of every joint of the scene's robot.
///
///   ~/reference  trajectory_msgs/JointTrajectoryPoint  positions in the order of the joints of the scene; before the first one the arm stays
///   ~/contacts   geometry_msgs/WrenchStamped           force and moment on a link, in its frame (header.frame_id); one message for each link
class BoundedForceController : public controller_interface::ControllerInterface {
 public:
  controller_interface::CallbackReturn on_init() override;
  controller_interface::InterfaceConfiguration command_interface_configuration() const override;
  controller_interface::InterfaceConfiguration state_interface_configuration() const override;
  controller_interface::CallbackReturn on_configure(const rclcpp_lifecycle::State& previous) override;
  controller_interface::CallbackReturn on_activate(const rclcpp_lifecycle::State& previous) override;
  controller_interface::return_type update(const rclcpp::Time& time, const rclcpp::Duration& period) override;

 private:
  /// Wrenches of all links, as they came last; copied as a whole into the loop.
  struct Wrench {
    std::string link;
    double time = 0;
    Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  };

  controller_interface::InterfaceConfiguration positions() const;
  void take_reference(const trajectory_msgs::msg::JointTrajectoryPoint& message);
  void take_contact(const geometry_msgs::msg::WrenchStamped& message);
  bool read_joints();

  std::shared_ptr<const stiction::world::Model> model_;
  std::vector<std::string> joints_;  ///< names of the URDF, in the order of the model
  std::optional<stiction::control::ContactController> controller_;
  std::optional<ContactBook> book_;
  std::vector<Wrench> wrenches_;  ///< of the subscription
  realtime_tools::RealtimeBuffer<std::vector<Wrench>> newest_wrenches_;
  realtime_tools::RealtimeBuffer<std::vector<double>> newest_reference_;
  Eigen::VectorXd q_, q_ref_;
  rclcpp::Subscription<trajectory_msgs::msg::JointTrajectoryPoint>::SharedPtr reference_;
  rclcpp::Subscription<geometry_msgs::msg::WrenchStamped>::SharedPtr contacts_;
};

}  // namespace stiction_ros2
