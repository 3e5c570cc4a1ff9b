#pragma once

// What the package uses of controller_interface and rclcpp_lifecycle, with the signatures of Jazzy.
#include <memory>
#include <string>
#include <vector>

#include "rclcpp/rclcpp.hpp"

namespace rclcpp_lifecycle {
struct State {};
using LifecycleNode = rclcpp::Node;
}  // namespace rclcpp_lifecycle

namespace hardware_interface {
class LoanedStateInterface {
 public:
  explicit LoanedStateInterface(const double& value) : value_(&value) {}
  double get_value() const { return *value_; }

 private:
  const double* value_;
};
class LoanedCommandInterface {
 public:
  explicit LoanedCommandInterface(double& value) : value_(&value) {}
  void set_value(double value) { *value_ = value; }

 private:
  double* value_;
};
}  // namespace hardware_interface

namespace controller_interface {

enum class CallbackReturn {
  SUCCESS,
  FAILURE,
  ERROR
};
enum class return_type {
  OK,
  ERROR
};
enum class interface_configuration_type {
  ALL,
  INDIVIDUAL,
  NONE
};
struct InterfaceConfiguration {
  interface_configuration_type type;
  std::vector<std::string> names;
};

class ControllerInterface {
 public:
  virtual ~ControllerInterface() = default;
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_configure(const rclcpp_lifecycle::State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_activate(const rclcpp_lifecycle::State&) { return CallbackReturn::SUCCESS; }
  virtual return_type update(const rclcpp::Time& time, const rclcpp::Duration& period) = 0;

  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() const { return node_; }

  // ---- for tests
  /// Joints that are there, by the names of their interfaces: what the controller asks for is lent to it in its order.
  void lend(const std::vector<double*>& states, const std::vector<double*>& commands) {
    state_interfaces_.clear();
    command_interfaces_.clear();
    for (double* value : states) state_interfaces_.emplace_back(*value);
    for (double* value : commands) command_interfaces_.emplace_back(*value);
  }

 protected:
  template <class T>
  T auto_declare(const std::string& name, const T& value) {
    return node_->declare_parameter<T>(name, value);
  }
  std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;
  std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;

 private:
  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node_ = std::make_shared<rclcpp_lifecycle::LifecycleNode>("controller");
};

}  // namespace controller_interface
