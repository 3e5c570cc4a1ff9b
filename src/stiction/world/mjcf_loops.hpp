#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "stiction/world/mjcf_couplings.hpp"

namespace stiction::world {

/// Joints that a `connect` of an MJCF closes to a loop with one joint that an actuator moves, as in the linkages of grippers.
///
/// The loop leaves the others where both anchors meet. What it leaves free, as in a finger that gives way, stands where its springs have the least energy within
/// the limits of the joints.
class MjcfLoop {
 public:
  /// @param equality  of type connect, between bodies
  /// @param line      what is known of a joint of the file
  /// @param driven    joints that lead and that an actuator moves
  /// @returns nothing where another number of joints than one is driven, no other joint moves, or one of them is no hinge or slide of the robot
  static std::optional<MjcfLoop> find(const mjModel& m, int equality, const MjcfView& view,
                                      const std::function<const MjcfCoupling&(int)>& line, const std::vector<bool>& driven);

  int leader() const { return leader_; }                    ///< the joint that is driven
  const std::vector<int>& joints() const { return free_; }  ///< those that follow it; each leads its own followers
  /// Where they stand while the leader is at x [rad, m]; NaN where the anchors do not meet. Looks from the last answer on.
  const Eigen::VectorXd& solve(double x);

 private:
  MjcfLoop(const mjModel& m, int equality);
  Eigen::VectorXd file_pose() const;
  bool close(double x, Eigen::VectorXd& y);
  void place(double x, const Eigen::VectorXd& y);
  Eigen::Vector3d anchor(int side) const;
  Eigen::Matrix3Xd gap_rates() const;

  const mjModel* m_;
  struct DeleteData {
    void operator()(mjData* data) const { mj_deleteData(data); }
  };
  std::unique_ptr<mjData, DeleteData> data_;
  int equality_;
  int leader_ = -1;
  std::vector<int> free_;
  std::vector<MjcfCoupling> lines_;       ///< of all joints that the leader and the free ones move
  Eigen::VectorXd lower_, upper_, rest_;  ///< of the free ones; rest of their springs
  Eigen::VectorXd stiffness_;             ///< of those springs, the largest 1
  double size_ = 0;                       ///< of the loop [m]
  std::optional<std::pair<double, Eigen::VectorXd>> last_;
  std::map<double, Eigen::VectorXd> solved_;
};

}  // namespace stiction::world
