#include "stiction/dynamics/disturbances.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

namespace stiction::dynamics {

Eigen::VectorXd calc_weights_aside(const world::Model& model, const Eigen::VectorXd& q, double angle, int draw) {
  Eigen::VectorXd tau = Eigen::VectorXd::Zero(model.n_v());
  const Eigen::Vector3d gravity = model.scene().gravity;
  if (gravity.norm() == 0) return tau;
  const Eigen::AngleAxisd turn(draw * 2 * std::numbers::pi / kDisturbances, gravity.normalized());
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

Eigen::VectorXd calc_friction_factors(const world::Model& model, const world::RobotChains& chains, double share, int draw) {
  using Draws = std::array<bool, kDisturbances>;
  constexpr Draws kNoRobot{false, false, true, true}, kEven{false, true, false, true}, kOdd{false, true, true, false};
  constexpr world::ChainMask kEvenBranches = 0x5555555555555555;
  Eigen::VectorXd factors(static_cast<Eigen::Index>(model.pairs().size()));
  for (int pair = 0; pair < factors.size(); ++pair) {
    const world::ChainMask branches = chains.mask_of_pair(pair);
    const Draws& less = branches == 0 ? kNoRobot : (branches & kEvenBranches) != 0 ? kEven : kOdd;
    factors[pair] = less[static_cast<std::size_t>(draw)] ? 1 - share : 1;
  }
  return factors;
}

}  // namespace stiction::dynamics
