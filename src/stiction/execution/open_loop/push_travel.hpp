#pragma once

#include <vector>

#include "stiction/contact/contact.hpp"
#include "stiction/world/model.hpp"

namespace stiction::execution {

/// How far a push takes what has to stop again: the objects, and the robot where it touches them.
/// Tests: tests/execution/run_timing_test.cpp
class PushTravel {
 public:
  explicit PushTravel(const world::Model& model);

  /// The largest way of a point from q0 to q1 (n_q) [m]: of the centres of an object's geometries and of what turns L/2 away from them, and of the points of the
  /// robot that touch an object at either.
  double calc(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1);

  /// At q0 or q1 nothing touches an object but what robots move.
  bool is_carried(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1);

 private:
  bool is_carried(const Eigen::VectorXd& q);
  double calc_of_objects() const;
  double calc_of_contacts(const world::Kinematics& at_end, const world::Kinematics& other);

  const world::Model& model_;
  std::vector<int> pairs_, resting_;  // of what robots move with objects; of what they do not
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics from_, to_;
  contact::Workspace contact_work_;
  std::vector<contact::Contact> contacts_;
};

}  // namespace stiction::execution
