#pragma once

#include <vector>

#include "stiction/planning/setting.hpp"

namespace stiction::planning {

/// Tools are objects with which robots move those objects of the goal that they cannot touch themselves.
/// Tests: tests/planning/tools_test.cpp
class Tools {
 public:
  explicit Tools(const Setting& setting);

  bool any() const { return !objects_.empty(); }
  /// A random tool, or −1: the subgoal is about the goal's own objects. Draws no random number if there are no tools.
  int draw(core::Random& random) const;
  /// Draws a subgoal for a tool when everything is at q (n_q). Most subgoals are places from which the tool can push an object of the goal
  /// nearer to its goal; the others are anywhere around.
  /// @param q_u  gets the tool's coordinates (n_qu)
  void draw_place(int object, const Eigen::VectorXd& q, core::Random& random, contact::GeometryWorkspace& work, Eigen::VectorXd& q_u) const;
  /// Draws a free place in contact with an object of the goal, such that the way of that object to its goal leads away from the tool.
  /// @returns false: all draws failed
  bool draw_behind(int object, const Eigen::VectorXd& q, core::Random& random, contact::GeometryWorkspace& work,
                   Eigen::VectorXd& q_u) const;
  /// Tells for each pair whether robots may take hold there to move the given objects: by these objects themselves, or by objects that at q
  /// are near enough to push one of them. Empty: there is no such pair.
  std::vector<char> touchable(const std::vector<int>& objects, const Eigen::VectorXd& q, contact::GeometryWorkspace& work) const;

 private:
  /// A pair of a tool with an object of the goal.
  struct Meeting {
    int pair, of_goal;
  };

  world::Pose turned(int object, const Eigen::VectorXd& q, core::Random& random) const;
  void draw_anywhere(int object, const Eigen::VectorXd& q, core::Random& random, Eigen::VectorXd& q_u) const;
  bool slide_to(int object, const Eigen::Vector3d& direction, Eigen::VectorXd& q, contact::GeometryWorkspace& work, Meeting& met,
                contact::Distance& distance) const;
  bool is_free_there(int object, contact::GeometryWorkspace& work) const;
  double goes_away(const Meeting& met, const contact::Distance& distance, const Eigen::VectorXd& q, contact::GeometryWorkspace& work) const;
  Eigen::Vector3d draw_level(core::Random& random) const;
  void put(int object, const world::Pose& X_WB, Eigen::VectorXd& q) const;

  const Setting& setting_;
  std::vector<int> objects_;
  std::vector<int> object_of_;                  // by geometry: the object that it belongs to, or −1
  std::vector<std::vector<Meeting>> meetings_;  // by object
  std::vector<double> radii_;                   // by object: bounding radius around the origin of its frame [m]
  Eigen::Vector3d up_;                          // 0 without gravity
};

}  // namespace stiction::planning
