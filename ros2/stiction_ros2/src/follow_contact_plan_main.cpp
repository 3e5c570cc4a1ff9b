// The node of the action: ros2 run stiction_ros2 follow_contact_plan --ros-args -p task:=/path/of/task.yaml
#include <exception>
#include <memory>

#include "rclcpp/rclcpp.hpp"
#include "stiction_ros2/follow_contact_plan.hpp"

int main(int argc, char** argv) {
  rclcpp::init(argc, argv);
  const auto node = std::make_shared<rclcpp::Node>("stiction");
  try {
    const stiction_ros2::FollowContactPlan server(node);
    rclcpp::spin(node);
  } catch (const std::exception& error) {  // its message names what was given and expected
    RCLCPP_ERROR(node->get_logger(), "%s", error.what());
    rclcpp::shutdown();
    return 2;
  }
  rclcpp::shutdown();
  return 0;
}
