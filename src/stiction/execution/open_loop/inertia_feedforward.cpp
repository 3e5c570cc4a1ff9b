#include "stiction/execution/open_loop/inertia_feedforward.hpp"

#include "stiction/world/robot_mass.hpp"

namespace stiction::execution {

using Eigen::VectorXd;

void add_inertia_lead(const world::Model& model, const std::vector<char>& free, const RunSpeeds& speeds, Trajectory& t) {
  const Eigen::Index n = t.times.size();
  const auto is_free = [&](Eigen::Index k) { return k < n && free[static_cast<std::size_t>(k)] != 0; };
  const auto step = [&](Eigen::Index k) { return k > 0 && k < n ? t.times[k] - t.times[k - 1] : 0; };
  const auto speed = [&](Eigen::Index k) -> VectorXd {
    if (step(k) == 0) return VectorXd::Zero(model.n_a());  // at rest before and after the trajectory
    return (t.q.col(k) - t.q.col(k - 1)).tail(model.n_a()) / step(k);
  };
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  const VectorXd most = speeds.most_room.cwiseQuotient(model.reach());
  VectorXd wanted = VectorXd::Zero(model.n_a()), lead = wanted, rate = wanted;  // M q̈/K, e, K/D
  for (Eigen::Index k = 0; k < n; ++k) {
    const VectorXd before = wanted;
    wanted.setZero();
    if (is_free(k + 1)) {  // contact, and not the motor, ends a free motion
      world::calc_kinematics(model, t.q.col(k), work, kinematics);
      const Eigen::MatrixXd M = world::calc_robot_mass(model, kinematics);
      rate = 0.5 * model.stiffness().cwiseQuotient(M.diagonal()).cwiseSqrt();
      wanted = (M * (speed(k + 1) - speed(k)) / (0.5 * (step(k) + step(k + 1)))).cwiseQuotient(model.stiffness());
      wanted = wanted.cwiseMax(-most).cwiseMin(most).eval();
    }
    if (k == 0) continue;
    const VectorXd fades = (-step(k) * rate).array().exp(), u_before = t.u.col(k - 1), farthest = speeds.most_free * step(k);
    lead = fades.cwiseProduct(lead) + (1 - fades.array()).matrix().cwiseProduct(0.5 * (before + wanted));
    if (k + 1 == n) lead.setZero();  // the last command stays in force
    const VectorXd u = (t.u.col(k) + lead).cwiseMax(u_before - farthest).cwiseMin(u_before + farthest);
    lead = u.cwiseMax(model.command_lower()).cwiseMin(model.command_upper()) - t.u.col(k);
    t.u.col(k) += lead;
  }
}

}  // namespace stiction::execution
