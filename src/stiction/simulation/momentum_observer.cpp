#include "stiction/simulation/momentum_observer.hpp"

#include <cmath>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::simulation {

namespace {
constexpr std::uint64_t kStream = 0x6f627376, kPostureStream = 0x706f7374;  // of random numbers
}  // namespace

void ObserverOptions::validate() const {
  core::require_positive("observer.time_constant", time_constant);
  core::require_nonnegative("observer.noise", noise);
  core::require_nonnegative("observer.bias", bias);
  core::require_nonnegative("observer.bias_reach", bias_reach);
  core::require_finite("observer.inertia_error", inertia_error);
  if (!(inertia_error > -1)) core::throw_invalid("observer.inertia_error", std::to_string(inertia_error), "a number > -1");
}

MomentumObserver::MomentumObserver(Eigen::Index joints, double period, const ObserverOptions& options)
    : options_(options), period_(period), random_(options.seed, kStream) {
  options.validate();
  core::require_positive("observer.period", period);
  gain_ = period / (options.time_constant + period);
  sensor_noise_ = options.noise * std::sqrt((2 - gain_) / gain_);
  p_.setZero(joints), r_.setZero(joints), cosine_.setZero(joints), sine_.setZero(joints), waves_.setZero(joints, joints);
  reset();
}

void MomentumObserver::reset() {
  random_ = core::Random(options_.seed, kStream);
  p_.setZero(), r_.setZero();
  for (double& xi : cosine_) xi = options_.bias * random_.normal();
  if (options_.bias_reach == 0) return;
  core::Random random(options_.seed, kPostureStream);
  for (double& eta : sine_) eta = options_.bias * random.normal();
  for (double& w : waves_.reshaped()) w = random.normal() / options_.bias_reach;
}

const Eigen::VectorXd& MomentumObserver::update(VectorRef p, VectorRef n, VectorRef tau, VectorRef q) {
  for (Eigen::Index j = 0; j < r_.size(); ++j) {
    const double phase = options_.bias_reach > 0 ? waves_.row(j).dot(q) : 0;
    const double measured = tau[j] + cosine_[j] * std::cos(phase) + sine_[j] * std::sin(phase) + sensor_noise_ * random_.normal();
    r_[j] += gain_ * ((p[j] - p_[j]) / period_ - measured - n[j] - r_[j]);
  }
  p_ = p;
  return r_;
}

}  // namespace stiction::simulation
