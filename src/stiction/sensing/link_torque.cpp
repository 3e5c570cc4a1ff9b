#include "stiction/sensing/link_torque.hpp"

#include <limits>

#include "stiction/world/axis.hpp"

namespace stiction::sensing {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

void LinkTorque::assign(const Matrix3Xd& J_w, const Matrix3Xd& J_v, VectorRef tau, Eigen::MatrixXd& scratch) {
  ww = J_w * J_w.transpose();
  wv = J_w * J_v.transpose();
  vv = J_v * J_v.transpose();
  w_tau = J_w * tau;
  v_tau = J_v * tau;
  tau_tau = tau.squaredNorm();

  // Modified Gram–Schmidt, with the right-hand side as the last column as stable as Householder's reflections (Björck 1967).
  constexpr int kColumns = 7;
  scratch.resize(tau.size(), kColumns);
  scratch << J_w.transpose(), J_v.transpose(), tau;
  Eigen::Matrix<double, 1, kColumns> lengths = scratch.colwise().norm();
  const double rounding = 10 * static_cast<double>(tau.size()) * std::numeric_limits<double>::epsilon();
  Eigen::Matrix<double, kSize, kColumns> R = Eigen::Matrix<double, kSize, kColumns>::Zero();
  for (int k = 0; k < kColumns; ++k) {
    const double length = scratch.col(k).norm();
    if (length <= rounding * lengths[k]) continue;  // in the span of those before
    R(k, k) = length;
    scratch.col(k) /= length;
    for (int j = k + 1; j < kColumns; ++j) {
      R(k, j) = scratch.col(k).dot(scratch.col(j));
      scratch.col(j) -= R(k, j) * scratch.col(k);
    }
  }
  R_w = R.leftCols<3>();
  R_v = R.middleCols<3>(3);
  R_tau = R.col(6);
}

void calc_link_jacobian(const world::Model& model, const world::Kinematics& kinematics, int body, Matrix3Xd& J_w, Matrix3Xd& J_v) {
  const auto& X_WL = kinematics.X_WB[static_cast<std::size_t>(body)];
  const Matrix3d R_LW = X_WL.R.transpose();
  J_w.setZero(3, model.n_a());
  J_v.setZero(3, model.n_a());
  for (const int axis : model.bodies()[static_cast<std::size_t>(body)].axes) {
    const auto [dof, kind, ratio] = world::axis_at(model, axis);  // a joint that follows another one moves the link with its leader
    const Vector3d direction = ratio * (R_LW * kinematics.axis_W.col(axis));
    const int column = dof - model.n_vu();
    if (kind == world::DofKind::Prismatic) {
      J_v.col(column) += direction;
    } else {
      J_w.col(column) += direction;
      J_v.col(column) += direction.cross(R_LW * (X_WL.p - kinematics.origin_W.col(axis)));
    }
  }
}

void calc_torque(const Matrix3Xd& J_w, const Matrix3Xd& J_v, const Vector3d& p, const Vector3d& f, Eigen::Ref<Eigen::VectorXd> tau) {
  tau.noalias() = J_w.transpose() * p.cross(f);
  tau.noalias() += J_v.transpose() * f;
}

}  // namespace stiction::sensing
