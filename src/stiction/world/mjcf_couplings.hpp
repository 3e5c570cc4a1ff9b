#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stiction/world/mjcf_view.hpp"

namespace stiction::world {

/// The value of a joint of an MJCF as a linear function of its leader's value: q = ratio·q_leader + offset. A joint that moves by itself is its
/// own leader. With leader −1, the joint is fixed at the offset.
struct MjcfCoupling {
  int joint = -1, leader = -1;
  double ratio = 1, offset = 0;
  double room = 0;  ///< deviation from this value that the file allows [rad or m]
};

/// Finds the joints of robots that follow other joints. Equalities, tendons with an actuator and tendons with a limit are linear relations
/// between joints. A relation between two leading joints makes one of them follow the other, preferably the one without an actuator. If a
/// `connect` closes a loop of bodies, the joints of the loop follow its actuated joint; each gets the line nearest to its values in the loop.
class MjcfCouplings : private MjcfView {
 public:
  explicit MjcfCouplings(const MjcfView& view);

  const MjcfCoupling& of(int joint) const { return lines_[static_cast<std::size_t>(joint)]; }
  /// Joints that follow or are fixed, in the order of the file.
  std::vector<MjcfCoupling> list() const;
  /// Leading joints on the tendon of an actuator, each with the motion of the tendon per motion of the joint. Joints with an actuator of their
  /// own are left out.
  std::vector<std::pair<int, double>> moved_by_tendon(int actuator) const;
  /// Limits that tendons impose on a leading joint [rad or m].
  std::optional<std::pair<double, double>> limits(int joint) const;
  const MjcfMeaning& meaning() const { return meaning_; }
  /// Deviations from the file, one sentence each.
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
  std::vector<std::string> unmoved_by_tendons() const;
  std::optional<int> narrow_follower(const Relation& length, int tendon) const;
  std::pair<double, double> range_of(int leader) const;
  std::pair<double, double> range_of(const Relation& length) const;

  std::vector<MjcfCoupling> lines_;  ///< per joint of the file
  std::vector<bool> has_motor_;      ///< per joint of the file: an actuator acts on it or on a follower of it
  std::vector<bool> driven_;         ///< the same, or an actuator acts on a tendon of these joints
  std::vector<std::optional<std::pair<double, double>>> limits_;
  std::vector<std::string> on_tendons_, curved_, in_loops_, kept_near_;
  MjcfMeaning meaning_;
};

}  // namespace stiction::world
