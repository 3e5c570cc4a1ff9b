#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "stiction/core/random.hpp"
#include "stiction/sensing/residual.hpp"

namespace stiction::sensing::test {

inline Eigen::MatrixXd random_matrix(core::Random& random, int rows, int cols) {
  Eigen::MatrixXd out(rows, cols);
  for (double& x : out.reshaped()) x = random.normal();
  return out;
}

/// A link behind `joints` revolute joints of an arm of about a metre, a torque, and a point on it with its frame.
struct RandomContact {
  Eigen::Matrix3Xd J_w, J_v;
  Eigen::VectorXd tau;
  Eigen::Vector3d p;
  Eigen::Matrix3d R;

  /// @param joints  of `all` that move the link  @param noise  share of the torque that no force makes [-]
  RandomContact(core::Random& random, int joints, int all, double noise) : J_w(3, all), J_v(3, all) {
    J_w.setZero();
    J_v.setZero();
    for (int j = 0; j < joints; ++j) {
      const Eigen::Vector3d axis = random_matrix(random, 3, 1).normalized(), origin = 0.5 * random_matrix(random, 3, 1);
      J_w.col(j) = axis;
      J_v.col(j) = axis.cross(-origin);
    }
    p = 0.1 * random_matrix(random, 3, 1);
    R = make_contact_frame(random_matrix(random, 3, 1).normalized());
    const Eigen::Vector3d f = 10 * random_matrix(random, 3, 1);
    tau = J_C().transpose() * f;
    tau += noise * tau.norm() * random_matrix(random, all, 1);
  }

  Eigen::Matrix3Xd J_C() const { return J_v - LinkTorque::skew(p) * J_w; }
  LinkTorque link() const { return LinkTorque(J_w, J_v, tau); }
  double objective(const Eigen::Vector3d& f_C) const { return (J_C().transpose() * (R * f_C) - tau).squaredNorm(); }
};

}  // namespace stiction::sensing::test
