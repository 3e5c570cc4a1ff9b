#include "stiction_ros2/bounded_force_controller.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/world/scene.hpp"

namespace stiction_ros2 {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::return_type;

ContactBook::ContactBook(const stiction::world::Model& model, double timeout)
    : model_(model), timeout_(timeout), work_(model), q_(model.neutral()) {
  for (std::size_t b = 0; b < model.bodies().size(); ++b) {
    if (model.bodies()[b].kind == stiction::world::BodyKind::Robot) entries_.push_back({.body = static_cast<int>(b)});
  }
  out_.reserve(entries_.size());
}

bool ContactBook::take(const std::string& link, double time, const Eigen::Vector3d& force, const Eigen::Vector3d& moment) {
  for (Entry& entry : entries_) {
    const std::string_view name = model_.bodies()[static_cast<std::size_t>(entry.body)].name;
    if (name != link && name.substr(name.find('/') + 1) != link) continue;
    entry.time = time;
    entry.f_L = force;
    entry.p_L = force.isZero(0) ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : Eigen::Vector3d(force.cross(moment) / force.squaredNorm());
    return true;
  }
  return false;
}

const std::vector<stiction::control::ContactForce>& ContactBook::contacts(double time, const Eigen::VectorXd& q) {
  out_.clear();
  q_.tail(model_.n_a()) = q;
  calc_kinematics(model_, q_, work_, kinematics_);
  for (const Entry& entry : entries_) {
    if (time - entry.time > timeout_ || entry.f_L.isZero(0)) continue;
    const stiction::world::Pose& X_WL = kinematics_.X_WB[static_cast<std::size_t>(entry.body)];
    out_.push_back({.id = entry.body, .body = entry.body, .p_WC = X_WL.p + X_WL.R * entry.p_L, .force_W = X_WL.R * entry.f_L});
  }
  return out_;
}

CallbackReturn BoundedForceController::on_init() {
  try {
    auto_declare<std::string>("scene", "");
    auto_declare<double>("lambda_max", 15.0);
    auto_declare<double>("force_threshold", 5.0);
    auto_declare<double>("contact_timeout", 0.1);
  } catch (const std::exception& error) {
    RCLCPP_ERROR(get_node()->get_logger(), "parameters: %s", error.what());
    return CallbackReturn::ERROR;
  }
  return CallbackReturn::SUCCESS;
}

InterfaceConfiguration BoundedForceController::positions() const {
  InterfaceConfiguration out{controller_interface::interface_configuration_type::INDIVIDUAL, {}};
  for (const std::string& joint : joints_) out.names.push_back(joint + "/" + hardware_interface::HW_IF_POSITION);
  return out;
}

InterfaceConfiguration BoundedForceController::command_interface_configuration() const { return positions(); }
InterfaceConfiguration BoundedForceController::state_interface_configuration() const { return positions(); }

CallbackReturn BoundedForceController::on_configure(const rclcpp_lifecycle::State&) {
  const auto node = get_node();
  try {
    const std::string scene = node->get_parameter("scene").as_string();
    model_ = stiction::world::Model::make(stiction::world::load_scene(scene, stiction::tasks::default_package_dirs()));
    stiction::control::ControllerOptions options;
    options.lambda_max = node->get_parameter("lambda_max").as_double();
    options.force_threshold = node->get_parameter("force_threshold").as_double();
    controller_.emplace(model_, options);
    const double timeout = node->get_parameter("contact_timeout").as_double();
    if (!(timeout > 0)) stiction::core::throw_invalid("contact_timeout", std::to_string(timeout), "> 0 [s]");
    book_.emplace(*model_, timeout);
  } catch (const std::exception& error) {  // its message names file, field and what was expected
    RCLCPP_ERROR(node->get_logger(), "%s", error.what());
    return CallbackReturn::ERROR;
  }
  joints_.clear();
  for (int j = 0; j < model_->n_a(); ++j) {
    const std::string& name = model_->dofs()[static_cast<std::size_t>(model_->n_vu() + j)].name;
    joints_.push_back(name.substr(name.find('/') + 1));
  }
  q_ = q_ref_ = Eigen::VectorXd::Zero(model_->n_a());
  wrenches_.clear();
  newest_wrenches_.writeFromNonRT(wrenches_);
  newest_reference_.writeFromNonRT({});
  reference_ = node->create_subscription<trajectory_msgs::msg::JointTrajectoryPoint>(
      "~/reference", rclcpp::SystemDefaultsQoS(),
      [this](const trajectory_msgs::msg::JointTrajectoryPoint& message) { take_reference(message); });
  contacts_ = node->create_subscription<geometry_msgs::msg::WrenchStamped>(
      "~/contacts", rclcpp::SystemDefaultsQoS(), [this](const geometry_msgs::msg::WrenchStamped& message) { take_contact(message); });
  return CallbackReturn::SUCCESS;
}

CallbackReturn BoundedForceController::on_activate(const rclcpp_lifecycle::State&) {
  if (!read_joints()) return CallbackReturn::ERROR;
  q_ref_ = q_;
  newest_reference_.writeFromNonRT({});  // one of before the arm was switched on is no wish of now
  controller_->configure(q_);
  return CallbackReturn::SUCCESS;
}

void BoundedForceController::take_reference(const trajectory_msgs::msg::JointTrajectoryPoint& message) {
  const bool fits = static_cast<int>(message.positions.size()) == model_->n_a() &&
                    std::ranges::all_of(message.positions, [](double x) { return std::isfinite(x); });
  if (!fits) {
    RCLCPP_WARN(get_node()->get_logger(), "reference: got %zu positions, expected %d finite ones; it is not taken",
                message.positions.size(), model_->n_a());
    return;
  }
  newest_reference_.writeFromNonRT(message.positions);
}

void BoundedForceController::take_contact(const geometry_msgs::msg::WrenchStamped& message) {
  Wrench wrench{message.header.frame_id, rclcpp::Time(message.header.stamp).seconds(), {}, {}};
  wrench.force << message.wrench.force.x, message.wrench.force.y, message.wrench.force.z;
  wrench.moment << message.wrench.torque.x, message.wrench.torque.y, message.wrench.torque.z;
  if (!wrench.force.allFinite() || !wrench.moment.allFinite()) return;
  const auto known = std::ranges::find(wrenches_, wrench.link, &Wrench::link);
  if (known != wrenches_.end()) {
    *known = wrench;
  } else {
    wrenches_.push_back(wrench);
  }
  newest_wrenches_.writeFromNonRT(wrenches_);
}

bool BoundedForceController::read_joints() {
  for (int j = 0; j < model_->n_a(); ++j) q_[j] = state_interfaces_[static_cast<std::size_t>(j)].get_value();
  return q_.allFinite();
}

return_type BoundedForceController::update(const rclcpp::Time& time, const rclcpp::Duration& period) {
  if (!read_joints()) return return_type::ERROR;
  if (period.seconds() <= 0) return return_type::OK;  // the first tick of a clock that has just begun
  for (const Wrench& wrench : *newest_wrenches_.readFromRT()) book_->take(wrench.link, wrench.time, wrench.force, wrench.moment);
  const std::vector<double>& reference = *newest_reference_.readFromRT();
  if (!reference.empty()) q_ref_ = Eigen::Map<const Eigen::VectorXd>(reference.data(), q_ref_.size());
  const auto& contacts = book_->contacts(time.seconds(), q_);
  const auto& command = controller_->update({.time = time.seconds(), .q = q_, .q_ref = q_ref_, .contacts = contacts}, period.seconds());
  for (int j = 0; j < model_->n_a(); ++j) command_interfaces_[static_cast<std::size_t>(j)].set_value(command.q_cmd[j]);
  return return_type::OK;
}

}  // namespace stiction_ros2

PLUGINLIB_EXPORT_CLASS(stiction_ros2::BoundedForceController, controller_interface::ControllerInterface)
