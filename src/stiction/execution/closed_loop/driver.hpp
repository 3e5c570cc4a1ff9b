#pragma once

#include <Eigen/Core>
#include <string>

namespace stiction::execution {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// What a driver says of its robot and of the objects.
struct Measurement {
  double time = 0;         ///< of its clock, when the joints were measured [s]
  double object_time = 0;  ///< … and when the objects were where q has them, ≤ time [s]
  Eigen::VectorXd q;       ///< (n_q) objects as last seen, joints as measured
  Eigen::VectorXd u;       ///< commands in force (n_a)
};

/// What carries commands out: a simulation, or a robot behind its driver. Joints are springs of stiffness Model::stiffness() from where they are to their
/// commands, damped against the speed of the commands, and no motor gives more than Model::effort().
class Driver {
 public:
  virtual ~Driver() = default;
  /// The newest measurement. False: none came in time; message() says what is known of it.
  virtual bool read(Measurement& out) = 0;
  /// Commands go straight from those in force to u (n_a) within `period` [s]; returns when it is over. They stay in force until the next ones, so that a
  /// caller who stops leaves the robot holding. False: not taken.
  virtual bool command(VectorRef u, double period) = 0;
  /// Its clock goes on by itself, and command() takes its period by it: it is commanded while the planner works. False: it waits for commands, as a
  /// simulation does.
  virtual bool real_time() const { return false; }
  virtual std::string message() const { return {}; }
};

}  // namespace stiction::execution
