#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "stiction/execution/closed_loop/driver.hpp"
#include "stiction/world/model.hpp"

namespace stiction_ros2 {

/// A robot behind topics, as `execution::run` wants it. Measurements come from the threads of subscriptions, the run has one of its own.
/// Joints are found by the names of the URDF. Objects have to move freely: others cannot be had from a pose alone.
class RosDriver : public stiction::execution::Driver {
 public:
  struct Outside {
    std::function<void(const Eigen::VectorXd& u, double period)> send;  ///< commands that are to be reached in `period` [s]
    std::function<void(double)> sleep;                                  ///< by the clock of the robot [s]
  };

  /// @param timeout  without a measurement of all joints and objects [s], > 0   @throws core::InvalidInput: an object on a joint
  RosDriver(std::shared_ptr<const stiction::world::Model> model, Outside outside, double timeout);

  void take_joints(double time, const std::vector<std::string>& names, const std::vector<double>& positions);
  /// @returns false: there is no such object
  bool take_object(const std::string& name, double time, const stiction::world::Pose& X_WB);

  bool read(stiction::execution::Measurement& out) override;
  bool command(stiction::execution::VectorRef u, double period) override;
  bool real_time() const override { return true; }
  std::string message() const override;

  /// Names of the URDF, in the order of the commands.
  const std::vector<std::string>& joints() const { return joints_; }

 private:
  bool complete() const;

  const std::shared_ptr<const stiction::world::Model> model_;
  const Outside outside_;
  const double timeout_;
  std::vector<std::string> joints_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  Eigen::VectorXd q_, u_;                           ///< u_ is empty before the first command
  std::vector<double> joint_times_, object_times_;  ///< NaN: never seen
  double read_time_;                                ///< of the last measurement that was handed out
  std::string missing_;                             ///< what the last read waited for
};

}  // namespace stiction_ros2
