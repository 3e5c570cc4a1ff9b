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

/// A loop of joints that a `connect` of an MJCF closes and in which an actuator moves one joint, as in the linkages of grippers.
///
/// The other joints take the values at which both anchors of the `connect` meet. If the loop does not determine them all, as in a compliant
/// finger, they take the values within their limits at which their springs have the least energy.
class MjcfLoop {
 public:
  /// Finds the loop that an equality closes.
  /// @param equality  equality of type connect, between bodies
  /// @param line      the coupling known so far of a joint of the file
  /// @param driven    per joint: true if it leads and an actuator moves it
  /// @returns nullopt unless exactly one joint is driven, another joint moves, and all of them are hinges or slides of the robot
  static std::optional<MjcfLoop> find(const mjModel& m, int equality, const MjcfView& view,
                                      const std::function<const MjcfCoupling&(int)>& line, const std::vector<bool>& driven);

  int leader() const { return leader_; }                    ///< the joint that is driven
  const std::vector<int>& joints() const { return free_; }  ///< the joints that follow the leader; each leads its own followers
  /// Computes the values of joints() for the leader at x [rad, m]; NaN if the anchors cannot meet. The search starts at the last solution.
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
  std::vector<MjcfCoupling> lines_;       ///< couplings of all joints that the leader and the free joints move
  Eigen::VectorXd lower_, upper_, rest_;  ///< limits of the free joints, and rest values of their springs
  Eigen::VectorXd stiffness_;             ///< stiffness of those springs, scaled so that the largest is 1
  double size_ = 0;                       ///< size of the loop [m]
  std::optional<std::pair<double, Eigen::VectorXd>> last_;
  std::map<double, Eigen::VectorXd> solved_;
};

}  // namespace stiction::world
