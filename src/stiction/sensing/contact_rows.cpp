#include "stiction/sensing/contact_rows.hpp"

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {

using Eigen::Index;
using Eigen::Matrix3d;

void BaseWrench::validate() const {
  core::require_finite("base_wrench.force", {force_W.data(), 3});
  core::require_finite("base_wrench.moment", {moment_W.data(), 3});
  core::require_positive("base_wrench.force_noise", force_noise);
  core::require_positive("base_wrench.moment_noise", moment_noise);
}

void calc_contact_rows(const world::Model& model, const world::Kinematics& kinematics, std::span<const int> bodies, VectorRef tau,
                       const BaseWrench* base, double noise, ContactRowsWorkspace& work, ContactRows& out,
                       const WhitenedTorques* whitened) {
  const Index joints = tau.size(), rows = joints + (base != nullptr ? 6 : 0);
  const double force_scale = base != nullptr ? noise / base->force_noise : 0,
               moment_scale = base != nullptr ? noise / base->moment_noise : 0;
  out.tau.resize(rows);
  out.tau.head(joints) = tau;
  if (base != nullptr) out.tau.tail<6>() << force_scale * base->force_W, moment_scale * base->moment_W;
  out.J_w.resize(bodies.size());
  out.J_v.resize(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    calc_link_jacobian(model, kinematics, bodies[i], work.J_w, work.J_v);
    if (whitened != nullptr) {
      whitened->apply(work.J_w);
      whitened->apply(work.J_v);
    }
    out.J_w[i].setZero(3, rows);
    out.J_v[i].setZero(3, rows);
    out.J_w[i].leftCols(joints) = work.J_w;
    out.J_v[i].leftCols(joints) = work.J_v;
    if (base == nullptr) continue;
    const auto& X_WL = kinematics.X_WB[static_cast<std::size_t>(bodies[i])];
    const Matrix3d R_LW = X_WL.R.transpose();
    out.J_v[i].middleCols<3>(joints) = force_scale * R_LW;
    out.J_w[i].rightCols<3>() = moment_scale * R_LW;
    out.J_v[i].rightCols<3>() = -moment_scale * R_LW * LinkTorque::skew(X_WL.p);
  }
}

BaseWrench calc_base_wrench(const Eigen::Vector3d& p_W, const Eigen::Vector3d& f_W) {
  BaseWrench out;
  out.force_W = f_W;
  out.moment_W = p_W.cross(f_W);
  return out;
}

}  // namespace stiction::sensing
