#include "stiction/execution/contact_control/base_sensor.hpp"

#include <cmath>

#include "stiction/core/invalid_input.hpp"

namespace stiction::execution {

namespace {
constexpr std::uint64_t kStream = 0x62617365, kPostureStream = 0x62706f73;  // streams of random numbers
}  // namespace

void BaseSensorOptions::validate() const {
  core::require_positive("estimator.base_wrench.force_noise", force_noise);
  core::require_positive("estimator.base_wrench.moment_noise", moment_noise);
  core::require_nonnegative("estimator.base_wrench.force_offset", force_offset);
  core::require_nonnegative("estimator.base_wrench.moment_offset", moment_offset);
}

BaseSensor::BaseSensor(Eigen::Index joints, double period, const simulation::ObserverOptions& torques, const BaseSensorOptions& options)
    : gain_(period / (torques.time_constant + period)), waves_(Eigen::MatrixXd::Zero(6, joints)), random_(torques.seed, kStream) {
  options.validate();
  torques.validate();
  core::require_positive("period", period);
  measured_.force_noise = options.force_noise, measured_.moment_noise = options.moment_noise;
  // White noise of deviation s before the lag leaves s √(a/(2 − a)) after it.
  white_ << Eigen::Vector3d::Constant(options.force_noise), Eigen::Vector3d::Constant(options.moment_noise);
  white_ *= std::sqrt((2 - gain_) / gain_);
  core::Random posture(torques.seed, kPostureStream);
  for (int i = 0; i < 6; ++i) {
    const double offset = i < 3 ? options.force_offset : options.moment_offset;
    cosine_[i] = offset * posture.normal();
    sine_[i] = torques.bias_reach > 0 ? offset * posture.normal() : 0;
  }
  if (torques.bias_reach > 0)
    for (double& w : waves_.reshaped()) w = posture.normal() / torques.bias_reach;
}

const sensing::BaseWrench& BaseSensor::update(const Vector6& wrench_W, const Eigen::Ref<const Eigen::VectorXd>& q) {
  for (int i = 0; i < 6; ++i) {
    const double phase = waves_.row(i).dot(q);
    noise_[i] += gain_ * (white_[i] * random_.normal() - noise_[i]);
    const double given = wrench_W[i] + noise_[i] + cosine_[i] * std::cos(phase) + sine_[i] * std::sin(phase);
    (i < 3 ? measured_.force_W[i] : measured_.moment_W[i - 3]) = given;
  }
  return measured_;
}

}  // namespace stiction::execution
