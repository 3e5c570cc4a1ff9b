#include "stiction/execution/open_loop/lag_allowance.hpp"

#include <algorithm>
#include <limits>

#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using Eigen::VectorXd;

/// Share of the distance to the nearest obstacle, since both sides may move.
constexpr double kShare = 0.5;

}  // namespace

LagAllowance::LagAllowance(const world::Model& model, double least)
    : model_(model), chains_(model), least_(least), most_(std::max(least, model.scales().robots().length)), geometry_(model) {}

double LagAllowance::calc(const VectorXd& u0, const VectorXd& u1, const VectorXd& q0, const VectorXd& q1) {
  const world::ChainMask moving = find_moving(u0, u1);
  if (moving != moving_) {
    moving_ = moving;
    chains_.pairs_of(moving, geometry_.pairs);
    q_.resize(0);
  }
  if (moving == 0) return least_;
  const double before = q_.size() > 0 && q_ == q0 ? distance_ : calc_distance(q0);  // q0 is often the q1 of the last call
  distance_ = calc_distance(q1);
  q_ = q1;
  return std::clamp(kShare * std::min(before, distance_), least_, most_);
}

world::ChainMask LagAllowance::find_moving(const VectorXd& u0, const VectorXd& u1) const {
  world::ChainMask moving = 0;
  for (int chain = 0; chain < chains_.size(); ++chain) {
    const auto joints = chains_.joints(chain);
    const auto moves = [&](int j) { return u0[j] != u1[j]; };
    if (std::any_of(joints.begin(), joints.end(), moves)) moving |= world::ChainMask{1} << chain;
  }
  return moving;
}

double LagAllowance::calc_distance(const VectorXd& q) {
  world::calc_kinematics(model_, q, geometry_.kinematics_work, geometry_.kinematics);
  return contact::calc_min_distance(model_, geometry_.kinematics, geometry_.pairs, -std::numeric_limits<double>::infinity(),
                                    geometry_.contact_work);
}

}  // namespace stiction::execution
