#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stiction/world/mjcf_view.hpp"

namespace stiction::world {

/// A joint of an MJCF as a line in one that leads it: q = ratio·q_leader + offset. A joint that leads is its own leader; with leader −1 it
/// stands at the offset.
struct MjcfCoupling {
  int joint = -1, leader = -1;
  double ratio = 1, offset = 0;
  double room = 0;  ///< how far from that the file lets it go [rad or m]
};

/// Which joints of robots follow others. Equalities, tendons with an actuator and tendons with a limit are linear relations between joints;
/// each relation between two that lead makes one of them follow the other, rather one that no actuator moves. Where bodies are connected to a loop, its joints
/// follow the one that an actuator moves, each by the line that is nearest to where the loop leaves it.
class MjcfCouplings : private MjcfView {
 public:
  explicit MjcfCouplings(const MjcfView& view);

  const MjcfCoupling& of(int joint) const { return lines_[static_cast<std::size_t>(joint)]; }
  /// Those that follow or stand still, in the order of the file.
  std::vector<MjcfCoupling> list() const;
  /// Joints that lead, and how far the tendon of an actuator moves per motion of each; those with an actuator of their own are left out.
  std::vector<std::pair<int, double>> moved_by_tendon(int actuator) const;
  /// Limits that tendons set to a joint that leads [rad or m].
  std::optional<std::pair<double, double>> limits(int joint) const;
  const MjcfMeaning& meaning() const { return meaning_; }
  /// What was taken otherwise than the file says, one sentence each.
  std::vector<std::string> notes() const;

 private:
  /// Σ c_j q_j + constant = 0.
  struct Relation {
    std::map<int, double> terms{};
    double constant = 0;
  };

  void find_motors();
  void take_equalities();
  void take_actuated_tendons();
  void take_loops();
  void take_narrow_limits();
  void take_other_limits();
  void take_springs();

  Relation relation_of_joints(int equality, double& error) const;
  std::optional<Relation> relation_of_tendons(int equality) const;
  Relation reduce(const Relation& relation) const;
  bool couple(const Relation& relation, int follower, bool only_to_driven = false);
  void follow(int joint, int leader, double ratio, double offset);
  std::optional<int> narrow_follower(const Relation& length, int tendon) const;
  std::pair<double, double> range_of(int leader) const;
  std::pair<double, double> range_of(const Relation& length) const;

  std::vector<MjcfCoupling> lines_;  ///< per joint of the file
  std::vector<bool> has_motor_;      ///< per joint of the file: an actuator on it, or on what follows it
  std::vector<bool> driven_;         ///< the same, or one on a tendon of them
  std::vector<std::optional<std::pair<double, double>>> limits_;
  std::vector<std::string> on_tendons_, curved_, in_loops_, kept_near_;
  MjcfMeaning meaning_;
};

}  // namespace stiction::world
