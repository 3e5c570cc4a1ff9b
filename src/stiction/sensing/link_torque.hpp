#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "stiction/world/model.hpp"

namespace stiction::sensing {

using VectorRef = world::VectorRef;

/// Joint torques and the torque map of one link, in the link's frame L, from which residuals are computed. A force f at p makes the torque
///     τ(p, f) = J_wᵀ (p × f) + J_vᵀ f = J_Cᵀ f ,   J_C = J_v − [p]× J_w        (Y.1)
/// with J_w, J_v (3 × n_a) the angular velocity of L and the velocity of its origin. Norms in torque space need only the
/// triangular factor of [J_wᵀ J_vᵀ τ] = Q R and the products of its columns, so no cost depends on the number of joints.
struct LinkTorque {
  static constexpr int kSize = 8;            ///< rows of R, padded with zeros to a multiple of four for SIMD registers
  Eigen::Matrix<double, kSize, 3> R_w, R_v;  ///< J_wᵀ, J_vᵀ
  Eigen::Matrix<double, kSize, 1> R_tau;     ///< τ
  Eigen::Matrix3d ww, wv, vv;                ///< J_w J_wᵀ [-], J_w J_vᵀ [m], J_v J_vᵀ [m²]
  Eigen::Vector3d w_tau, v_tau;              ///< J_w τ [N·m], J_v τ [N·m²]
  double tau_tau = 0;                        ///< τᵀτ [(N·m)²]
  double prior = 0;                          ///< ρ ‖f‖² is added to every residual (Y.2) [m²]; assign() leaves it

  LinkTorque() = default;
  LinkTorque(const Eigen::Matrix3Xd& J_w, const Eigen::Matrix3Xd& J_v, VectorRef tau) {
    Eigen::MatrixXd scratch;
    assign(J_w, J_v, tau, scratch);
  }
  /// No heap use once `scratch` is n_a × 7.
  void assign(const Eigen::Matrix3Xd& J_w, const Eigen::Matrix3Xd& J_v, VectorRef tau, Eigen::MatrixXd& scratch);

  /// J_Cᵀ at p, up to an orthogonal factor.
  Eigen::Matrix<double, kSize, 3> torque_map(const Eigen::Vector3d& p) const { return R_v + R_w * skew(p); }

  /// J_w r and J_v r for r = τ(p, f) − τ.
  Eigen::Vector3d w_residual(const Eigen::Vector3d& p, const Eigen::Vector3d& f) const { return ww * p.cross(f) + wv * f - w_tau; }
  Eigen::Vector3d v_residual(const Eigen::Vector3d& p, const Eigen::Vector3d& f) const {
    return wv.transpose() * p.cross(f) + vv * f - v_tau;
  }

  static Eigen::Matrix3d skew(const Eigen::Vector3d& p) {
    return (Eigen::Matrix3d() << 0, -p.z(), p.y(), p.z(), 0, -p.x(), -p.y(), p.x(), 0).finished();
  }
};

/// J_w and J_v of a robot's link in its own axes (3 × n_a), columns in the order of u. No heap use once they have that size.
void calc_link_jacobian(const world::Model& model, const world::Kinematics& kinematics, int body, Eigen::Matrix3Xd& J_w,
                        Eigen::Matrix3Xd& J_v);

/// τ(p, f) (Y.1) [N·m; N of prismatic joints].
void calc_torque(const Eigen::Matrix3Xd& J_w, const Eigen::Matrix3Xd& J_v, const Eigen::Vector3d& p_L, const Eigen::Vector3d& f_L,
                 Eigen::Ref<Eigen::VectorXd> tau);

}  // namespace stiction::sensing
