#include "stiction/sensing/residual_map.hpp"

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {

std::vector<LinkTorque> make_link_torques(const Sensor& sensor, VectorRef q, VectorRef tau, const WhitenedTorques* whitened) {
  const world::Model& model = sensor.model();
  world::require_configuration(model, "q", q);
  core::require_size("tau", tau.size(), model.n_a());
  core::require_finite("tau", {tau.data(), static_cast<std::size_t>(tau.size())});
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  Eigen::Matrix3Xd J_w, J_v;
  std::vector<LinkTorque> out;
  for (const SensedLink& link : sensor.links()) {
    calc_link_jacobian(model, kinematics, link.surface.body, J_w, J_v);
    if (whitened == nullptr) {
      out.emplace_back(J_w, J_v, tau);
      continue;
    }
    whitened->apply(J_w);
    whitened->apply(J_v);
    out.emplace_back(J_w, J_v, whitened->tau());
  }
  return out;
}

std::vector<Eigen::VectorXd> calc_residual_map(const Sensor& sensor, VectorRef q, VectorRef tau, const FrictionCone& cone,
                                               const WhitenedTorques* whitened) {
  const std::vector<LinkTorque> torques = make_link_torques(sensor, q, tau, whitened);
  std::vector<Eigen::VectorXd> out;
  for (std::size_t i = 0; i < torques.size(); ++i) {
    const SampleBatch& batch = sensor.links()[i].batch;
    Eigen::VectorXd& residuals = out.emplace_back(batch.rows.cols());
    calc_residuals(torques[i], batch, cone, residuals);
    residuals.conservativeResize(batch.size);
  }
  return out;
}

}  // namespace stiction::sensing
