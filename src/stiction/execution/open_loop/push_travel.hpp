#pragma once

#include <vector>

#include "stiction/contact/contact.hpp"
#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Computes the travel in a push of everything that has to stop again: of the objects, and of the robot's points that touch them (E.13).
/// Tests: tests/execution/run_timing_test.cpp
class PushTravel {
 public:
  explicit PushTravel(const world::Model& model);

  /// Largest travel of a point from q0 to q1 (n_q) [m]. The points are the centres of an object's geometries with the rotation at the distance L/2, and the
  /// points of the robot that touch an object at q0 or q1.
  double calc(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1);

 private:
  double calc_of_objects() const;
  double calc_of_contacts(const world::Kinematics& at_end, const world::Kinematics& other);

  const world::Model& model_;
  std::vector<int> pairs_;  // of objects with moving links
  world::KinematicsWorkspace kinematics_work_;
  world::Kinematics from_, to_;
  contact::Workspace contact_work_;
  std::vector<contact::Contact> contacts_;
};

}  // namespace stiction::execution
