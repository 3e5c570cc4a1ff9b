#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stiction/world/mjcf_couplings.hpp"

namespace stiction::world {

/// Forces from `lower` to `upper` [N·m, N].
struct ForceRange {
  double lower = 0, upper = 0;

  bool is_zero() const { return lower == 0 && upper == 0; }
  ForceRange scaled(double factor) const;
  ForceRange clamped(const mjtNum* range) const;  ///< each end moved into the range
  ForceRange operator+(const ForceRange& other) const { return {lower + other.lower, upper + other.upper}; }
};

/// Motor of a coordinate of a robot.
struct MjcfMotor {
  std::optional<double> spring{};                       ///< stiffness [N·m/rad, N/m]
  std::optional<double> effort{};                       ///< largest force in both directions [N·m, N]
  double servo_damping = 0;                             ///< k_v of position servos [N·m·s/rad, N·s/m]
  double passive_spring = 0;                            ///< spring of a joint that no actuator moves [N·m/rad, N/m]
  std::optional<std::pair<double, double>> commands{};  ///< positions to which servos may be commanded, if the file limits them [rad, m]
  bool driven = false;                                  ///< an actuator moves the coordinate, directly or through a tendon
};

/// Stiffness and effort of the joints of robots, from the actuators, springs and tendons of a compiled MJCF. A force on a follower counts for its
/// leader.
class MjcfMotors : private MjcfView {
 public:
  explicit MjcfMotors(const MjcfView& view);

  const MjcfMotor& of(int dof) const { return motors_[static_cast<std::size_t>(dof)]; }
  const MjcfCouplings& couplings() const { return couplings_; }
  /// Deviations from the file, one sentence each.
  std::vector<std::string> notes() const;

 private:
  MjcfMotor& of_joint(int joint) { return motors_[static_cast<std::size_t>(m_->jnt_dofadr[joint])]; }
  std::string name_of(int dof) const;
  ForceRange range_of(int actuator) const;
  ForceRange range_of_tendon(int tendon) const;
  void add_actuator(int actuator);
  void add_servo(int actuator, MjcfMotor& motor, double lever);
  void add_commands(int actuator, const MjcfCoupling& line);
  void add_tendon(int tendon);
  void set_efforts();
  void set_effort(int dof, const ForceRange& range);
  void add_spring(int joint);
  std::vector<std::string> without_actuator() const;

  std::vector<MjcfMotor> motors_;   ///< per dof of the file
  std::vector<ForceRange> forces_;  ///< per dof: of the actuators on its own joint
  std::vector<ForceRange> sums_;    ///< per dof: of the actuators on its joint and on the followers of this joint, in its coordinate
  std::vector<std::string> sprung_, unsprung_, one_sided_, uneven_, mixed_;
  MjcfCouplings couplings_;
};

}  // namespace stiction::world
