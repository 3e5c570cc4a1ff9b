#include "stiction/simulation/servos.hpp"

#include <algorithm>

namespace stiction::simulation {

namespace {

/// Most damping of a joint in its file, as a share of M_jj per timestep: at this damping it stops within ten timesteps. The torque that overcomes
/// it belongs to the speed before the timestep, so it acts as an inertia of this share.
constexpr double kMostDamping = 0.1;

}  // namespace

Servos::Servos(const Plant::Impl& plant)
    : plant_(plant),
      mujoco_(mj_copyModel(nullptr, plant.mujoco.get())),
      lead_(Eigen::VectorXd::Zero(plant.model->n_a())),
      overcome_(Eigen::VectorXd::Zero(plant.model->n_a())) {}

void Servos::damp(const mjData& data, const Eigen::VectorXd& rate) {
  calc_inertia(plant_, data, inertia_);
  calc_damping(plant_, inertia_, damping_);
  for (Eigen::Index j = 0; j < damping_.size(); ++j)
    mujoco_->actuator_biasprm[plant_.actuator_id[static_cast<std::size_t>(j)] * mjNBIAS + 2] = -damping_[j];
  if (plant_.options.velocity_reference) lead_ = damping_.cwiseQuotient(plant_.model->stiffness());
  if (plant_.options.joint_friction) return;  // then the scene has the whole friction of the joints
  const world::Model& model = *plant_.model;
  for (Eigen::Index j = 0; j < damping_.size(); ++j) {
    const auto v = static_cast<std::size_t>(model.n_vu() + j);
    if (model.dofs()[v].damping == 0) continue;
    const double d = std::min(model.dofs()[v].damping, kMostDamping * inertia_[model.n_vu() + j] / plant_.options.timestep);
    mujoco_->dof_damping[plant_.v_address[v]] = d;
    if (!plant_.options.velocity_reference) continue;
    const double speed = data.qvel[plant_.v_address[v]];
    overcome_[j] = d * std::clamp(speed, std::min(rate[j], 0.0), std::max(rate[j], 0.0)) / model.stiffness()[j];
  }
}

}  // namespace stiction::simulation
