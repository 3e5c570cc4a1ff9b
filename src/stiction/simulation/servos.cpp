#include "stiction/simulation/servos.hpp"

#include <cmath>

namespace stiction::simulation {

namespace {
std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }
}  // namespace

Servos::Servos(const Plant::Impl& plant) : plant_(plant), mujoco_(mj_copyModel(nullptr, plant.mujoco.get())) {
  const mjModel* m = mujoco_.get();
  const int n_a = plant.model->n_a(), n_vu = plant.model->n_vu();
  std::vector<int> joint(at(m->nv), -1);  // of the robot that moves a joint of the simulation
  std::vector<double> ratio(at(m->nv), 0);
  for (int j = 0; j < n_a; ++j) {
    const auto address = at(plant.v_address[at(n_vu + j)]);
    joint[address] = j, ratio[address] = 1;
  }
  for (std::size_t i = 0; i < plant.follower_v_address.size(); ++i) {
    const world::Follower& follower = plant.model->followers()[i];
    const auto address = at(plant.follower_v_address[i]);
    joint[address] = follower.dof - n_vu, ratio[address] = follower.ratio;
  }
  for (int row = 0; row < m->nv; ++row) {
    for (int entry = m->M_rowadr[row]; entry < m->M_rowadr[row] + m->M_rownnz[row]; ++entry) {  // lower triangle
      const int column = m->M_colind[entry];
      if (joint[at(row)] < 0 || joint[at(row)] != joint[at(column)]) continue;
      terms_.push_back({joint[at(row)], entry, (row == column ? 1 : 2) * ratio[at(row)] * ratio[at(column)]});
    }
  }
  inertia_.setZero(n_a), lead_.setZero(n_a);
}

void Servos::damp(const mjData& data) {
  inertia_.setZero();
  for (const Term& term : terms_) inertia_[term.joint] += term.weight * data.M[term.entry];
  const Eigen::VectorXd& stiffness = plant_.model->stiffness();
  for (Eigen::Index j = 0; j < inertia_.size(); ++j) {
    const double damping = 2 * plant_.options.damping_ratio * std::sqrt(stiffness[j] * inertia_[j]);
    mujoco_->actuator_biasprm[plant_.actuator_id[at(j)] * mjNBIAS + 2] = -damping;
    if (plant_.options.velocity_reference) lead_[j] = damping / stiffness[j];
  }
}

}  // namespace stiction::simulation
