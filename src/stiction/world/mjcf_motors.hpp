#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stiction/world/mjcf_couplings.hpp"

namespace stiction::world {

/// Stiffness and effort of the joints of robots, from the actuators, springs and tendons of a compiled MJCF. A force on a follower counts for its
/// leader.
class MjcfMotors : private MjcfView {
 public:
  explicit MjcfMotors(const MjcfView& view);

  std::optional<double> spring(int joint) const { return spring_[static_cast<std::size_t>(joint)]; }  ///< [N·m/rad, N/m]
  double servo_damping(int joint) const {
    return damping_[static_cast<std::size_t>(joint)];
  }  ///< k_v of position servos [N·m·s/rad, N·s/m]
  double passive_spring(int joint) const { return passive_[static_cast<std::size_t>(joint)]; }        ///< of a joint that no actuator moves
  std::optional<double> effort(int joint) const { return effort_[static_cast<std::size_t>(joint)]; }  ///< [N·m, N]
  /// Positions to which servos on a joint may be commanded, if the file limits them.
  std::optional<std::pair<double, double>> commands(int joint) const { return commands_[static_cast<std::size_t>(joint)]; }  ///< [rad, m]
  const MjcfCouplings& couplings() const { return couplings_; }
  /// Deviations from the file, one sentence each.
  std::vector<std::string> notes() const;

 private:
  void find_springs();
  double gear_of(int actuator) const;
  void add_actuator(int actuator, int joint, double lever);
  void add_commands(int actuator, const MjcfCoupling& line);
  void add_spring(int joint);
  std::vector<std::string> without_actuator() const;

  std::vector<std::optional<double>> spring_, effort_;              ///< per joint of the file
  std::vector<double> damping_, passive_;                           ///< per joint of the file
  std::vector<std::optional<std::pair<double, double>>> commands_;  ///< per joint of the file
  std::vector<bool> has_actuator_;  ///< per joint of the file: an actuator moves it, directly or through a tendon
  std::vector<std::string> sprung_, unsprung_;
  MjcfCouplings couplings_;
};

}  // namespace stiction::world
