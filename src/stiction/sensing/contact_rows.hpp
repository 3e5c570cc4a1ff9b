#pragma once

#include <span>
#include <vector>

#include "stiction/sensing/link_torque.hpp"
#include "stiction/sensing/torque_noise.hpp"

namespace stiction::sensing {

/// Measurement of a force and moment sensor under the base of a robot: the sum of all contact forces, and of their moments about W's
/// origin.
struct BaseWrench {
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();   ///< [N]
  Eigen::Vector3d moment_W = Eigen::Vector3d::Zero();  ///< [N·m]
  double force_noise = 1;                              ///< standard deviation of each component [N], > 0
  double moment_noise = 0.1;                           ///< the same [N·m], > 0
  void validate() const;                               ///< @throws core::InvalidInput naming the field
};

/// The measurements as rows τ = J_wᵀ (p × f) + J_vᵀ f (Y.1) of a force on each link: joint torques, then the wrench at the base (Y.9a),
/// whose rows are scaled so that all have the noise of a torque.
struct ContactRows {
  std::vector<Eigen::Matrix3Xd> J_w, J_v;  ///< of each link (3 × rows)
  Eigen::VectorXd tau;                     ///< (rows)
};

/// Scratch of calc_contact_rows(); one per thread.
struct ContactRowsWorkspace {
  Eigen::Matrix3Xd J_w, J_v;
};

/// Computes the rows of each link. @param bodies  of the links  @param base  nullptr: no base sensor  @param noise  of a torque [N·m]
/// @param whitened  defines the coordinates of `tau` and the rows (Y.17); nullptr: joint torques
void calc_contact_rows(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> bodies, VectorRef tau,
                       const BaseWrench* base, double noise, ContactRowsWorkspace& work, ContactRows& out,
                       const WhitenedTorques* whitened = nullptr);

/// Base wrench of a force at a point, both in W, with the default noise.
BaseWrench calc_base_wrench(const Eigen::Vector3d& p_W, const Eigen::Vector3d& f_W);

}  // namespace stiction::sensing
