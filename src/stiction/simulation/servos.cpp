#include "stiction/simulation/servos.hpp"

namespace stiction::simulation {

Servos::Servos(const Plant::Impl& plant)
    : plant_(plant), mujoco_(mj_copyModel(nullptr, plant.mujoco.get())), lead_(Eigen::VectorXd::Zero(plant.model->n_a())) {}

void Servos::damp(const mjData& data) {
  calc_inertia(plant_, data, inertia_);
  calc_damping(plant_, inertia_, damping_);
  for (Eigen::Index j = 0; j < damping_.size(); ++j)
    mujoco_->actuator_biasprm[plant_.actuator_id[static_cast<std::size_t>(j)] * mjNBIAS + 2] = -damping_[j];
  if (plant_.options.velocity_reference) lead_ = damping_.cwiseQuotient(plant_.model->stiffness());
}

}  // namespace stiction::simulation
