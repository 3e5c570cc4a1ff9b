#include "stiction/simulation/impedance.hpp"

#include <cmath>
#include <numbers>

#include "stiction/core/invalid_input.hpp"

namespace stiction::simulation {

void ImpedanceOptions::validate() const {
  core::require_nonnegative("impedance.damping_ratio", damping_ratio);
  core::require_positive("impedance.velocity_cutoff", velocity_cutoff);
  core::require_positive("impedance.gain_cutoff", gain_cutoff);
  core::require_positive("impedance.period", period);
}

ImpedanceController::ImpedanceController(const Eigen::VectorXd& K, const ImpedanceOptions& options) : K_(K), options_(options) {
  options.validate();
  for (const double k : K) core::require_positive("stiffness", k);
  velocity_.setZero(K.size()), damping_.setZero(K.size()), torque_.setZero(K.size());
}

const Eigen::VectorXd& ImpedanceController::update(VectorRef q, VectorRef v, VectorRef q_cmd, VectorRef M_ii) {
  const auto gain = [&](double cutoff) {
    const double step = options_.period * 2 * std::numbers::pi * cutoff;
    return started_ ? step / (1 + step) : 1.0;  // filters start where their input is
  };
  const double of_velocity = gain(options_.velocity_cutoff), of_damping = gain(options_.gain_cutoff);
  for (Eigen::Index j = 0; j < K_.size(); ++j) {
    velocity_[j] += of_velocity * (v[j] - velocity_[j]);
    damping_[j] += of_damping * (2 * options_.damping_ratio * std::sqrt(K_[j] * M_ii[j]) - damping_[j]);
    torque_[j] = K_[j] * (q_cmd[j] - q[j]) - damping_[j] * velocity_[j];
  }
  started_ = true;
  return torque_;
}

}  // namespace stiction::simulation
