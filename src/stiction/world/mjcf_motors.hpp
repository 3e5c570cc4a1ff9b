#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stiction/world/mjcf_view.hpp"

namespace stiction::world {

/// A joint of an MJCF that follows another one: y = ratio·x + offset.
struct MjcfCoupling {
  int joint = -1, leader = -1;  ///< leader −1: it stands at the offset
  double ratio = 0, offset = 0;
};

/// Springs and efforts of the joints of robots, and which of them follow others, as actuators, springs, tendons and equalities of a compiled
/// MJCF say.
class MjcfMotors : private MjcfView {
 public:
  explicit MjcfMotors(const MjcfView& view);

  std::optional<double> spring(int joint) const { return spring_[static_cast<std::size_t>(joint)]; }  ///< [N·m/rad, N/m]
  std::optional<double> effort(int joint) const { return effort_[static_cast<std::size_t>(joint)]; }  ///< [N·m, N]
  const std::vector<MjcfCoupling>& couplings() const { return couplings_; }
  /// What was taken otherwise than the file says, one sentence each.
  std::vector<std::string> notes() const;

 private:
  void find_springs();
  void find_equalities();
  double gear_of(int actuator) const;
  void add_actuator(int actuator, int joint, double lever);
  void add_tendon(int actuator);
  MjcfCoupling read_equality(int equality, double& error) const;
  std::vector<std::string> without_actuator() const;

  std::vector<std::optional<double>> spring_, effort_;  ///< per joint of the file
  std::vector<bool> has_actuator_;                      ///< per joint of the file: an actuator moves it, itself or by a tendon
  std::vector<std::string> sprung_, unsprung_, on_tendons_, curved_;
  std::vector<MjcfCoupling> couplings_;
};

}  // namespace stiction::world
