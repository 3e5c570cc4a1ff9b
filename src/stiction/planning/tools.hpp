#pragma once

#include <vector>

#include "stiction/planning/setting.hpp"

namespace stiction::planning {

/// Objects with which robots move those of the goal that they cannot touch themselves.
/// Tests: tests/planning/tools_test.cpp
class Tools {
 public:
  explicit Tools(const Setting& setting);

  bool any() const { return !objects_.empty(); }
  /// One of them, or −1: the draw is for the goal's own objects. Draws no number where there are none.
  int draw(core::Random& random) const;
  /// A subgoal for a tool, from where everything is at q (n_q). Most are places from which it can push an object of the goal nearer to its goal; the
  /// others are anywhere around.
  /// @param q_u  gets the tool's coordinates (n_qu)
  void draw_place(int object, const Eigen::VectorXd& q, core::Random& random, contact::GeometryWorkspace& work, Eigen::VectorXd& q_u) const;
  /// In contact with an object of the goal, and with nothing in it; the way of that object to its goal leads away from it.
  /// @returns false: draws were used up
  bool draw_behind(int object, const Eigen::VectorXd& q, core::Random& random, contact::GeometryWorkspace& work,
                   Eigen::VectorXd& q_u) const;
  /// Per pair, whether robots may take hold there to move the given objects: of these, and of what is near enough to one of them at q to push it.
  /// Empty: there is none.
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
  std::vector<int> object_of_;                  // geometry: the object that it belongs to, −1: none
  std::vector<std::vector<Meeting>> meetings_;  // by object
  std::vector<double> radii_;                   // by object, around the origin of its frame [m]
  Eigen::Vector3d up_;                          // 0 without gravity
};

}  // namespace stiction::planning
