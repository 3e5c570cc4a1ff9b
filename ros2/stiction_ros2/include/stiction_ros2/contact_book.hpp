#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "stiction/control/controller.hpp"
#include "stiction/world/model.hpp"

namespace stiction_ros2 {

/// The last wrench of each link, as contacts for a controller. No heap use after the first call of contacts().
///
/// A contact without friction torque has the wrench (f, m) with m = p × f. Every p on its line of action makes the same joint torques, and
/// p = f × m / ‖f‖² is the one nearest to the origin of the link.
class ContactBook {
 public:
  ContactBook(const stiction::world::Model& model, double timeout);

  /// A wrench on a link, in axes of the link and about its origin. @param link  "robot/link", or "link" where that is clear
  /// @returns false: there is no such link
  bool take(const std::string& link, double time, const Eigen::Vector3d& force, const Eigen::Vector3d& moment);
  /// What is not older than the timeout, in the world at q (n_a).
  const std::vector<stiction::control::ContactForce>& contacts(double time, const Eigen::VectorXd& q);

 private:
  struct Entry {
    int body = -1;
    double time = -1e30;
    Eigen::Vector3d p_L = Eigen::Vector3d::Zero(), f_L = Eigen::Vector3d::Zero();
  };
  const stiction::world::Model& model_;
  const double timeout_;
  std::vector<Entry> entries_;
  std::vector<stiction::control::ContactForce> out_;
  stiction::world::KinematicsWorkspace work_;
  stiction::world::Kinematics kinematics_;
  Eigen::VectorXd q_;
};

}  // namespace stiction_ros2
