#pragma once

#include <Eigen/Core>
#include <string>

namespace stiction::execution {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// Measurement of robot and objects by a driver.
struct Measurement {
  double time = 0;         ///< time on the driver's clock at which the joints were measured [s]
  double object_time = 0;  ///< time at which the objects had the poses in q, ≤ time [s]
  Eigen::VectorXd q;       ///< configuration (n_q): objects as last seen, joints as measured
  Eigen::VectorXd u;       ///< commands in force (n_a)
};

/// Interface of a simulation, or of a robot behind its driver, that carries out commands. Joints are springs of stiffness Model::stiffness() between the joint
/// positions and their commands. They are damped by the difference of joint speed and command speed, and no motor gives more than Model::effort().
class Driver {
 public:
  virtual ~Driver() = default;
  /// Writes the newest measurement to `out`. @returns false if none came in time; message() then says what is known of the cause
  virtual bool read(Measurement& out) = 0;
  /// Moves the commands on a straight line from those in force to u (n_a) within `period` [s], and returns when the period is over. The commands stay in force
  /// until the next call, so the robot holds if the caller stops. @returns false if the command was not taken
  virtual bool command(VectorRef u, double period) = 0;
  /// True: the clock of the plant goes on by itself, and command() takes `period` on this clock; the run commands the plant while the planner works. False: the
  /// plant waits for commands, as a simulation does.
  virtual bool real_time() const { return false; }
  virtual std::string message() const { return {}; }
};

}  // namespace stiction::execution
