#include "stiction/simulation/servos.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stiction::simulation {

namespace {

/// Most damping of a joint in its file, as a share of M_jj per timestep: at this damping it stops within some timesteps. The torque that overcomes
/// it belongs to the speed before the timestep, so it acts as an inertia of this share.
constexpr double kMostDamping = 1.0 / 3;

}  // namespace

Servos::Servos(const Plant::Impl& plant)
    : plant_(plant), mujoco_(mj_copyModel(nullptr, plant.mujoco.get())), lead_(Eigen::VectorXd::Zero(plant.model->n_a())) {}

void Servos::damp(const mjData& data) {
  calc_inertia(plant_, data, inertia_);
  calc_damping(plant_, inertia_, damping_);
  for (Eigen::Index j = 0; j < damping_.size(); ++j)
    mujoco_->actuator_biasprm[plant_.actuator_id[static_cast<std::size_t>(j)] * mjNBIAS + 2] = -damping_[j];
  if (plant_.options.velocity_reference) lead_ = damping_.cwiseQuotient(plant_.model->stiffness());
}

void Servos::overcome_damping(mjData& data) {
  if (plant_.options.joint_friction) return;  // the scene has the friction and damping of the joints
  const world::Model& model = *plant_.model;
  const std::size_t first = plant_.q_address.size() - static_cast<std::size_t>(model.n_a());
  for (Eigen::Index j = 0; j < damping_.size(); ++j) {
    const auto i = static_cast<std::size_t>(j), v = static_cast<std::size_t>(model.n_vu()) + i;
    if (model.dofs()[v].damping == 0) continue;
    const double d = std::min(model.dofs()[v].damping, kMostDamping * inertia_[model.n_vu() + j] / plant_.options.timestep);
    const int dof = plant_.v_address[v];
    mujoco_->dof_damping[dof] = d;
    double& command = data.ctrl[plant_.actuator_id[i]];
    const double K = model.stiffness()[j], strain = command - data.qpos[plant_.q_address[first + i]];
    const double asked = damping_[j] > 0 ? K / damping_[j] * strain : std::copysign(std::numeric_limits<double>::infinity(), strain);
    command += d / K * std::clamp(data.qvel[dof], std::min(asked, 0.0), std::max(asked, 0.0));
  }
}

}  // namespace stiction::simulation
