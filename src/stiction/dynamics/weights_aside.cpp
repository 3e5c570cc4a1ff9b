#include "stiction/dynamics/weights_aside.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace stiction::dynamics {

Eigen::VectorXd calc_weights_aside(const world::Model& model, const Eigen::VectorXd& q, double angle, int side) {
  Eigen::VectorXd tau = Eigen::VectorXd::Zero(model.n_v());
  const Eigen::Vector3d gravity = model.scene().gravity;
  if (gravity.norm() == 0) return tau;
  const Eigen::AngleAxisd turn(side * 2 * std::numbers::pi / kSides, gravity.normalized());
  const Eigen::Vector3d aside = turn * (gravity.unitOrthogonal() * std::tan(angle) * gravity.norm());
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    const auto& object = model.objects()[i];
    const world::ObjectSpec& spec = model.scene().objects[i];
    if (spec.joint != world::ObjectJoint::Free) continue;
    const Eigen::Vector3d force = spec.weight_share * object.mass * aside;
    tau.segment<3>(object.v_begin) = force;
    if (spec.p_BCom.isZero(0)) continue;
    const Eigen::Matrix3d R_WB = Eigen::Quaterniond(Eigen::Vector4d(q.segment<4>(object.q_begin + 3))).toRotationMatrix();
    tau.segment<3>(object.v_begin + 3) = spec.p_BCom.cross(R_WB.transpose() * force);
  }
  return tau;
}

}  // namespace stiction::dynamics
