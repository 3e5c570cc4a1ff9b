#include "stiction_ros2/follow_contact_plan.hpp"

#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/plan_file.hpp"

namespace stiction_ros2 {

using stiction::execution::RunResult;
using stiction::execution::RunSample;

FollowContactPlan::FollowContactPlan(rclcpp::Node::SharedPtr node) : node_(std::move(node)) {
  declare();
  subscribe();
  server_ = rclcpp_action::create_server<Action>(
      node_, "follow_contact_plan",
      [this](const rclcpp_action::GoalUUID&, const std::shared_ptr<const Action::Goal>& goal) { return ask(*goal); },
      [](const std::shared_ptr<Handle>&) { return rclcpp_action::CancelResponse::ACCEPT; },
      [this](const std::shared_ptr<Handle>& handle) { start(handle); });
}

FollowContactPlan::~FollowContactPlan() {
  stop_ = true;
  if (worker_.joinable()) worker_.join();
}

void FollowContactPlan::declare() {
  task_ = stiction::tasks::load_task(node_->declare_parameter<std::string>("task", ""));
  how_.tick = node_->declare_parameter<double>("tick", 0.01);
  how_.watch_interval = node_->declare_parameter<double>("watch_interval", 0.02);
  how_.duration = node_->declare_parameter<double>("duration", how_.duration);
  how_.validate();
  const double timeout = node_->declare_parameter<double>("timeout", 0.5);
  const auto sleep = [this](double seconds) { (void)node_->get_clock()->sleep_for(rclcpp::Duration::from_seconds(seconds)); };
  const auto send = [this](const Eigen::VectorXd& u, double period) { this->send(u, period); };
  driver_ = std::make_unique<RosDriver>(task_.model, RosDriver::Outside{send, sleep}, timeout);
}

void FollowContactPlan::subscribe() {
  const rclcpp::SystemDefaultsQoS qos;
  joint_states_ =
      node_->create_subscription<sensor_msgs::msg::JointState>("joint_states", qos, [this](const sensor_msgs::msg::JointState& message) {
        driver_->take_joints(rclcpp::Time(message.header.stamp).seconds(), message.name, message.position);
      });
  for (const auto& object : task_.model->objects()) {
    const auto take = [this, name = object.name](const geometry_msgs::msg::PoseStamped& message) {
      const auto& [p, q] = message.pose;
      const stiction::world::Pose X_WB{Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix(),
                                       Eigen::Vector3d(p.x, p.y, p.z)};
      driver_->take_object(name, rclcpp::Time(message.header.stamp).seconds(), X_WB);
    };
    objects_.push_back(node_->create_subscription<geometry_msgs::msg::PoseStamped>("objects/" + object.name, qos, take));
  }
  commands_ = node_->create_publisher<trajectory_msgs::msg::JointTrajectory>("joint_trajectory", qos);
}

void FollowContactPlan::send(const Eigen::VectorXd& u, double period) const {
  trajectory_msgs::msg::JointTrajectory message;
  message.joint_names = driver_->joints();
  auto& point = message.points.emplace_back();
  point.positions.assign(u.begin(), u.end());
  point.time_from_start.sec = static_cast<std::int32_t>(period);
  point.time_from_start.nanosec = static_cast<std::uint32_t>(std::llround(1e9 * (period - std::floor(period))));
  commands_->publish(message);
}

rclcpp_action::GoalResponse FollowContactPlan::ask(const Action::Goal&) {
  return busy_.exchange(true) ? rclcpp_action::GoalResponse::REJECT : rclcpp_action::GoalResponse::ACCEPT_AND_EXECUTE;
}

void FollowContactPlan::start(const std::shared_ptr<Handle>& handle) {
  if (worker_.joinable()) worker_.join();  // the one before has ended
  worker_ = std::thread([this, handle] {
    const auto result = std::make_shared<Action::Result>();
    try {
      carry_out(handle, *result);
    } catch (const std::exception& error) {
      result->message = error.what();
    }
    busy_ = false;
    if (result->reached) {
      handle->succeed(result);
    } else if (handle->is_canceling()) {
      handle->canceled(result);
    } else {
      handle->abort(result);
    }
  });
}

void FollowContactPlan::carry_out(const std::shared_ptr<Handle>& handle, Action::Result& result) {
  const Action::Goal& goal = *handle->get_goal();
  stiction::tasks::Task task = task_;
  std::optional<stiction::planning::Plan> first;
  if (!goal.plan.empty()) {
    const stiction::tasks::PlanFile file = stiction::tasks::read_plan(goal.plan);
    if (file.scene_sha256 != task.scene_sha256)
      stiction::core::throw_invalid("plan", goal.plan + ", of another scene", "one of the task " + task.name);
    first = stiction::tasks::to_plan(*task.model, file);
    task.problem.goal = first->goal;
  }
  if (!goal.goal.empty()) stiction::tasks::set_goal(task, goal.goal);
  stiction::execution::RunOptions how = how_;
  if (goal.duration > 0) how.duration = goal.duration;
  how.on_sample = [&handle](const RunSample& sample) {
    const auto feedback = std::make_shared<Action::Feedback>();
    feedback->time = sample.time;
    feedback->state = std::string(stiction::execution::to_string(sample.state));
    feedback->goal_share = sample.goal_share;
    feedback->plans = static_cast<std::uint32_t>(sample.plans);
    feedback->piece = sample.piece;
    handle->publish_feedback(feedback);
  };
  stiction::core::RunControl control;
  control.abandoned = [this, &handle] { return stop_.load() || handle->is_canceling(); };
  RunResult out;
  (void)stiction::execution::run(*driver_, task.problem, task.options, how, control, out,
                                 first ? &*first : nullptr);  // `out` says how it ended
  result.reached = out.reached();
  result.message = out.message;
  result.position_error = out.error.position;
  result.angle_error = out.error.angle;
  result.duration = out.duration_s;
  result.plans = static_cast<std::uint32_t>(out.plans.size());
}

}  // namespace stiction_ros2
