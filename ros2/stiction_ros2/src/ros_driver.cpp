#include "stiction_ros2/ros_driver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "stiction/core/invalid_input.hpp"

namespace stiction_ros2 {
namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

}  // namespace

RosDriver::RosDriver(std::shared_ptr<const stiction::world::Model> model, Outside outside, double timeout)
    : model_(std::move(model)), outside_(std::move(outside)), timeout_(timeout), q_(model_->neutral()), read_time_(-1e30) {
  for (const auto& object : model_->objects()) {
    if (object.n_q != 7) stiction::core::throw_invalid("objects", "'" + object.name + "', which is on a joint", "objects that move freely");
  }
  for (int j = 0; j < model_->n_a(); ++j) {
    const std::string& name = model_->dofs()[static_cast<std::size_t>(model_->n_vu() + j)].name;
    joints_.push_back(name.substr(name.find('/') + 1));
  }
  joint_times_.assign(joints_.size(), kNever);
  object_times_.assign(model_->objects().size(), kNever);
}

void RosDriver::take_joints(double time, const std::vector<std::string>& names, const std::vector<double>& positions) {
  const std::scoped_lock lock(mutex_);
  for (std::size_t i = 0; i < std::min(names.size(), positions.size()); ++i) {
    const auto found = std::ranges::find(joints_, names[i]);
    if (found == joints_.end() || !std::isfinite(positions[i])) continue;  // of another robot, or no number
    const auto j = found - joints_.begin();
    q_[model_->n_qu() + j] = positions[i];
    joint_times_[static_cast<std::size_t>(j)] = time;
  }
  arrived_.notify_all();
}

bool RosDriver::take_object(const std::string& name, double time, const stiction::world::Pose& X_WB) {
  for (std::size_t i = 0; i < model_->objects().size(); ++i) {
    const auto& object = model_->objects()[i];
    if (object.name != name) continue;
    const std::scoped_lock lock(mutex_);
    const Eigen::Quaterniond turn(X_WB.R);
    q_.segment<3>(object.q_begin) = X_WB.p;
    q_.segment<4>(object.q_begin + 3) = turn.normalized().coeffs();  // x y z w
    object_times_[i] = time;
    arrived_.notify_all();
    return true;
  }
  return false;
}

bool RosDriver::complete() const {
  const auto seen = [](double time) { return !std::isnan(time); };
  return std::ranges::all_of(joint_times_, seen) && std::ranges::all_of(object_times_, seen) && std::ranges::min(joint_times_) > read_time_;
}

bool RosDriver::read(stiction::execution::Measurement& out) {
  std::unique_lock lock(mutex_);
  if (!arrived_.wait_for(lock, std::chrono::duration<double>(timeout_), [this] { return complete(); })) {
    missing_.clear();
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (!(joint_times_[j] > read_time_)) missing_ += (missing_.empty() ? "" : ", ") + joints_[j];
    }
    for (std::size_t i = 0; i < object_times_.size(); ++i) {
      if (std::isnan(object_times_[i])) missing_ += (missing_.empty() ? "" : ", ") + model_->objects()[i].name;
    }
    return false;
  }
  out.time = read_time_ = std::ranges::min(joint_times_);
  out.object_time = object_times_.empty() ? out.time : std::min(out.time, std::ranges::min(object_times_));
  out.q = q_;
  out.u = u_.size() > 0 ? u_ : Eigen::VectorXd(q_.tail(model_->n_a()));
  return true;
}

bool RosDriver::command(stiction::execution::VectorRef u, double period) {
  const Eigen::VectorXd sent = u;
  {
    const std::scoped_lock lock(mutex_);
    u_ = sent;
  }
  outside_.send(sent, period);
  outside_.sleep(period);
  return true;
}

std::string RosDriver::message() const { return missing_.empty() ? "" : "nothing new of " + missing_; }

}  // namespace stiction_ros2
